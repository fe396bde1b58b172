// The faces around a vertex, fan by fan between sharp edges.
#pragma once

#include <patchwright/mesh/regular.h>

#include <vector>

namespace patchwright::patch {

/// How the limit surface meets a vertex on one side of its sharp edges (infinitely sharp ones and
/// the boundary; finite sharpness has no part in the limit at the vertex).
enum class FanKind {
    Ring,    ///< smooth all around
    Crease,  ///< between two sharp edges that go on into each other smoothly
    Dart,    ///< all around from the only sharp edge back to it
    Corner,  ///< between two sharp edges that meet at an angle
    Fold,    ///< all around from a sharp vertex's only sharp edge back to it: runs back into itself
    Spike    ///< a sharp vertex without sharp edges
};

/// Whether the limit surface has a tangent plane there, for any shape of the cage.
constexpr bool has_tangent_plane(FanKind kind) {
    return kind != FanKind::Fold && kind != FanKind::Spike;
}

/// Faces that follow each other counter-clockwise around a vertex, smooth edges between them.
struct Fan {
    mesh::VertexId vertex;
    FanKind kind = FanKind::Ring;
    bool is_controlled = false;  ///< a sector's angle makes the rules of its edges
    /// Per face its corner at the vertex, which is the half-edge that leaves the vertex clockwise.
    std::vector<mesh::CornerId> corners;

    [[nodiscard]] int size() const { return static_cast<int>(corners.size()); }
    [[nodiscard]] bool is_closed() const { return kind == FanKind::Ring || kind == FanKind::Spike; }
    /// Whether the limit surface there is that of a regular grid.
    [[nodiscard]] bool is_regular() const;
};

/// In counter-clockwise order; the first fan holds or follows t.corner(v).
std::vector<Fan> fans_around(const mesh::Topology& t, mesh::VertexId v);

/// Position of a corner within its face.
int position(const mesh::Topology& t, mesh::CornerId c);

}  // namespace patchwright::patch
