// The limit surface of a cage as bicubic B-spline patches.
#pragma once

#include <patchwright/mesh/cage.h>
#include <patchwright/patch/patch_set.h>

namespace patchwright::patch {

struct ExtractOptions {
    /// Levels of knots towards an extraordinary corner: outside [0, 2^-cap_depth]^2 there the patch
    /// is the limit surface exactly; 1 to 20.
    int cap_depth = 8;
};

struct Extraction {
    PatchSet patches;
    mesh::Cage
        cage;  ///< the cage whose faces the patches are, in order: refined as often as needed
    int refinements = 0;  ///< Catmull-Clark steps from the given cage to that one
    int caps = 0;         ///< patches with an extraordinary corner
};

/// One patch a face. Cages with other polygons than quads, semi-sharp features, or faces with more
/// than one extraordinary corner are refined first, which does not change the limit surface.
/// Source: control points as blossoms of the regular pieces around an extraordinary corner; the
/// corner's own control point is its limit point. Neighbouring patches share their boundary curve
/// exactly.
/// @throw InvalidArgument when cap_depth is out of range
Extraction extract(const mesh::Cage& cage, const ExtractOptions& options = {});

/// The middle of every crease edge's curve, one row each; empty when there are none.
geom::Points crease_midpoints(const PatchSet& patches);

}  // namespace patchwright::patch
