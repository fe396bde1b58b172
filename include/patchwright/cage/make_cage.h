// Control meshes from CAD models and triangle meshes.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/model_surface.h>
#include <patchwright/mesh/cage.h>

#include <string>
#include <vector>

namespace patchwright::cage {

enum class Method {
    Auto,     ///< aligned where a layout is found, else remesh
    Aligned,  ///< blocks along the lines of a wing, or else of the model's faces
    Remesh    ///< even triangles that keep features, paired to quads: works on every shape
};

struct CageOptions {
    Method method = Method::Auto;
    int target_faces = 0;         ///< number of faces to aim at, roughly; 0: as the shape asks for
    double tolerance_rel = 1e-3;  ///< of the diagonal: what the cage is to be fitted to
    double fineness = 1.0;        ///< > 0: edges are shorter by this factor where shape asks for it
    /// A ball in which a remeshed cage has edges of half the length; of a quarter where it meets
    /// one of another round. Those of one round may overlap.
    struct Place {
        geom::Vec3 point = geom::Vec3::Zero();
        double radius = 0.0;  ///< millimetres
        int round = 0;        ///< 0 to 31
    };
    std::vector<Place> finer_at;
    base::Progress progress;
};

struct CageResult {
    mesh::Cage cage;
    Method method = Method::Remesh;    ///< what was used: Aligned or Remesh
    int recognised = 0;                ///< bodies laid out as wings, blades or nacelles
    bool from_faces = false;           ///< some bodies are laid out along their faces
    std::vector<std::string> notices;  ///< one line each, for the user
    /// One line a body unless all were to be remeshed: what it was recognised as, or why not.
    std::vector<std::string> layout;
};

/// A cage whose limit surface is near the model: sharp edges are creases, corners corners, free
/// edges boundaries; faces carry the names of the model's. A model with no sharp edges gives a
/// cage without creases.
/// @throw InvalidArgument when an option is out of range
/// @throw InputError when the model cannot be triangulated, or with Method::Aligned when no layout
///        is found
CageResult make_cage(const geom::ModelSurface& model, const CageOptions& options = {});

}  // namespace patchwright::cage
