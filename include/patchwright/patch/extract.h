// The limit surface of a cage as bicubic B-spline patches.
#pragma once

#include <patchwright/mesh/cage.h>
#include <patchwright/patch/patch_set.h>

#include <optional>

#pragma GCC visibility push(default)
namespace patchwright::patch {

/// How patches meet at extraordinary vertices.
enum class Join {
    G1,      ///< tangent planes agree exactly
    Refined  ///< knots towards the vertex make the remaining kink small
};

/// What one patch covers.
enum class Covering {
    Charts,  ///< as many faces as possible
    Faces    ///< one face
};

/// Largest number of knot levels towards an extraordinary vertex.
inline constexpr int max_cap_depth = 20;

struct ExtractOptions {
    Join join = Join::G1;
    Covering covering = Covering::Charts;
    /// How far caps may lie from the limit surface; empty: 1e-5 of the diagonal of the cage.
    std::optional<double> tolerance_mm;
    /// Levels of knots towards extraordinary vertices, 1 to max_cap_depth; empty: what the
    /// tolerance takes. Where the cage is not regular enough around the vertex it takes more.
    std::optional<int> cap_depth;
};

/// What was done at one side of an extraordinary vertex.
struct CapReport {
    mesh::VertexId vertex;     ///< of Extraction::cage
    int faces = 0;             ///< around the vertex on this side of its sharp edges
    int depth = 0;             ///< knots come as near as 2^-depth of a face
    double distance_mm = 0.0;  ///< largest measured distance from the limit surface
    /// Whether tangent planes agree exactly. They do not with Join::Refined, where the limit
    /// surface has no tangent plane, and at some corners: those whose sharp edges are nearly
    /// parallel, and those where a smooth cap would fold.
    bool smooth = false;
    /// Not at sharp vertices with one sharp edge or none, where it ends in a point or a fold.
    bool limit_has_plane = true;
};

struct Extraction {
    PatchSet patches;
    /// The cage whose faces the patches cover: the given one, or its first refinement when that has
    /// other polygons than quads.
    mesh::Cage cage;
    int refinements = 0;          ///< Catmull-Clark steps from the given cage to that one
    std::vector<CapReport> caps;  ///< by vertex
};

/// Covers the limit surface by untrimmed patches. Away from extraordinary vertices they are the
/// limit surface, C2 inside; near them, within squares of size 2^(1 - depth) of a face (Refined:
/// 2^-depth), they deviate by at most the tolerance. Neighbouring patches share their boundary
/// curves; where a corner of a patch meets the side of another, the side consists of several edges.
/// Source: control points are blossoms of the regular pieces around an extraordinary vertex; see
/// src/decisions/007-caps.md.
/// @throw InvalidArgument when the tolerance is not positive or the depth out of range
/// @throw InputError when a sector's angle makes rules inside it
Extraction extract(const mesh::Cage& cage, const ExtractOptions& options = {});

/// The middle of every crease edge's curve, one row each; empty when there are none.
geom::Points crease_midpoints(const PatchSet& patches);

/// Vertices around which the patches have no common tangent plane, one row each: the limit surface
/// has none there, or a cap is not smooth.
geom::Points singular_points(const Extraction& extraction);

}  // namespace patchwright::patch
#pragma GCC visibility pop
