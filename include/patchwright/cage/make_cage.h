// Control meshes from CAD models and triangle meshes.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/model_surface.h>
#include <patchwright/mesh/cage.h>

#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::cage {

enum class Method {
    Auto,     ///< aligned where a layout is found, else remesh
    Aligned,  ///< blocks along the lines of a wing, or else of the model's faces
    Remesh    ///< even triangles that keep features, paired to quads: works on every shape
};

/// Where the edges of a remeshed cage are shorter: in the union of some balls. Where regions
/// overlap their factors multiply.
struct FinerRegion {
    struct Ball {
        geom::Vec3 centre = geom::Vec3::Zero();
        double radius_mm = 0.0;
        bool operator==(const Ball&) const = default;
    };
    std::vector<Ball> balls;
    double edge_length_factor = 0.5;  ///< > 0: of lengths that curvature asks for
    bool operator==(const FinerRegion&) const = default;
};

/// How blocks of a body are found.
enum class BlockWay {
    Fewest,  ///< both ways; those with fewer extraordinary vertices are taken
    Field,   ///< between the lines of a cross field
    Faces,   ///< along faces
    None     ///< not at all: the body is remeshed
};

struct CageOptions {
    Method method = Method::Auto;
    /// Number of faces to aim at, met within about 20 %; none: as many as the shape asks for.
    std::optional<int> target_faces;
    double tolerance_rel = 1e-3;  ///< of the diagonal: what the cage is to be fitted to
    /// > 0: edges whose length curvature decides are shorter by this factor, and a wing has as many
    /// times more rings. To be doubled when the fit of a cage misses the tolerance by little.
    double fineness = 1.0;
    BlockWay blocks = BlockWay::Fewest;  ///< of bodies that are not recognised
    std::vector<FinerRegion> finer_at;   ///< for where the fit of a remeshed cage misses
    base::Progress progress;
};

struct CageResult {
    mesh::Cage cage;
    Method method = Method::Remesh;    ///< what was used: Aligned or Remesh
    int recognised = 0;                ///< bodies laid out as wings, blades or nacelles
    bool from_field = false;           ///< some bodies are laid out by lines of a cross field
    bool from_faces = false;           ///< some bodies are laid out along their faces
    bool faces_refused = false;        ///< some bodies were found to have no blocks along faces
    std::vector<std::string> notices;  ///< one line each, for the user
    /// One line a body unless all were to be remeshed: what it was recognised as, or why not.
    std::vector<std::string> layout;
};

/// A cage whose limit surface is near the model: sharp edges are creases, corners corners, free
/// edges boundaries; faces carry the names of the model's. A model with no sharp edges gives a
/// cage without creases.
/// @throw InvalidArgument when an option is out of range
/// @throw Cancelled or what CageOptions::progress throws, when that stops the work
/// @throw InputError when the model cannot be triangulated, or with Method::Aligned when no layout
///        is found
CageResult make_cage(const geom::ModelSurface& model, const CageOptions& options = {});

}  // namespace patchwright::cage
#pragma GCC visibility pop
