// Points that move on the limit surface, and along its sharp edges and border.
#pragma once

#include "grid/limit_face.h"

#include <patchwright/subd/limit_mask.h>

#include <memory>
#include <optional>
#include <unordered_map>

namespace patchwright::grid {

/// A place on a half-edge: 0 at its start, 1 at its end.
struct LinePlace {
    mesh::CornerId edge;
    double t = 0.0;
};

/// Whether points must stay on the edge: it is sharp or semi-sharp, or the surface ends there.
bool is_feature(const mesh::Topology& topology, mesh::CornerId edge);

/// The same place in the face's parameters.
subd::Location location_of(const mesh::Topology& topology, const LinePlace& at);

/// Walks from place to place. One a thread, as LimitFace.
class SurfaceWalk {
  public:
    /// @pre the cage has quads only; table and cage outlive this
    SurfaceWalk(subd::RingTable& table, const mesh::Cage& cage) : table_(table), cage_(cage) {}

    [[nodiscard]] LimitFace::Tangents at(const subd::Location& place);
    /// Direction of the curve over a half-edge, towards its end; up to a positive factor where the
    /// place is an extraordinary vertex.
    [[nodiscard]] geom::Vec3 direction(const LinePlace& place);

    /// The place whose point is nearly `by` away: Newton's steps, each over one face at most. Does
    /// not cross features.
    [[nodiscard]] subd::Location moved(const subd::Location& place, const geom::Vec3& by);
    /// The same along features; ends where other than two of them meet.
    [[nodiscard]] LinePlace moved(const LinePlace& place, const geom::Vec3& by);

  private:
    LimitFace& face(mesh::FaceId f);
    [[nodiscard]] subd::Location off_vertex(const subd::Location& place, const geom::Vec3& by);
    [[nodiscard]] subd::Location walked(subd::Location place, double du, double dv) const;
    [[nodiscard]] LinePlace walked(LinePlace place, double dt) const;

    subd::RingTable& table_;
    const mesh::Cage& cage_;
    std::unordered_map<std::int32_t, LimitFace> faces_;
};

/// The other feature at a vertex, where there are two and no corner's tag: the half-edge that
/// leaves there or, where there is only that one, the one that comes in.
struct NextFeature {
    mesh::CornerId edge;
    bool reversed = false;
};
std::optional<NextFeature> next_feature(const mesh::Topology& topology, mesh::VertexId at,
                                        mesh::EdgeId edge);

}  // namespace patchwright::grid
