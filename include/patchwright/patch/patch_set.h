// B-spline patches with shared edges and vertices: what the B-rep is assembled from.
#pragma once

#include <patchwright/base/colour.h>
#include <patchwright/geom/bspline.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::patch {

enum class EdgeContinuity {
    Position,
    TangentPlane,
    Curvature  ///< two derivatives in the surfaces' own parameters
};

using base::Colour;

/// A curve between two vertices, shared by the patches on its sides.
struct PatchEdge {
    int start = 0;  ///< vertex at curve.begin()
    int end = 0;    ///< vertex at curve.end()
    geom::BsplineCurve curve;
    bool crease = false;  ///< the tangent plane may jump here
    /// How the surfaces on both sides meet; position only at creases, and beside vertices without
    /// a common tangent plane.
    EdgeContinuity continuity = EdgeContinuity::Position;
};

/// One use of an edge as (part of) the side of a patch.
struct EdgeUse {
    int edge = 0;
    bool reversed = false;  ///< the patch's counter-clockwise boundary runs against the curve
};

/// One untrimmed surface; its four sides in counter-clockwise order are
/// v = v0 (u rising), u = u1 (v rising), v = v1 (u falling), u = u0 (v falling).
struct Patch {
    geom::BsplineSurface surface;
    std::array<std::vector<EdgeUse>, 4> sides;  ///< each in counter-clockwise order, at least one
    std::string name;
    bool has_cap = false;          ///< a corner is an extraordinary vertex
    std::optional<Colour> colour;  ///< for formats that have colours
};

/// Invariants: the curve of an edge lies on the side of each patch that uses it; an edge is used
/// once (free) or twice, in opposite directions. Normals du x dv point outward where the cage's
/// faces do.
struct PatchSet {
    geom::Points vertices;
    std::vector<PatchEdge> edges;
    std::vector<Patch> patches;
};

}  // namespace patchwright::patch
#pragma GCC visibility pop
