// The connectivity of a control mesh with its subdivision tags; holds no positions.
#pragma once

#include <patchwright/base/ids.h>
#include <patchwright/mesh/topology_input.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::mesh {

using VertexId = base::Id<struct VertexTag>;
using EdgeId = base::Id<struct EdgeTag>;
using FaceId = base::Id<struct FaceTag>;
/// A face's corner, which is also the half-edge from this corner's vertex to the next one's.
using CornerId = base::Id<struct CornerTag>;

/// Immutable half-edge connectivity of oriented manifold polygons, with or without boundary.
class Topology {
  public:
    /// Connects checked input in linear time. Use mesh::build_cage for data that nobody checked.
    /// @pre faces are consistently oriented and manifold; every tag names an existing element
    explicit Topology(const TopologyInput& input);

    [[nodiscard]] int vertex_count() const { return static_cast<int>(vertex_corner_.size()); }
    [[nodiscard]] int edge_count() const { return static_cast<int>(edge_corner_.size()); }
    [[nodiscard]] int face_count() const { return static_cast<int>(face_begin_.size()) - 1; }
    [[nodiscard]] int corner_count() const { return static_cast<int>(corner_vertex_.size()); }

    [[nodiscard]] base::IdRange<VertexId> vertices() const { return {0, vertex_count()}; }
    [[nodiscard]] base::IdRange<EdgeId> edges() const { return {0, edge_count()}; }
    [[nodiscard]] base::IdRange<FaceId> faces() const { return {0, face_count()}; }

    [[nodiscard]] base::IdRange<CornerId> corners(FaceId f) const {
        return {face_begin_[f.index()], face_begin_[f.index() + 1]};
    }
    [[nodiscard]] int size(FaceId f) const { return corners(f).size(); }

    [[nodiscard]] VertexId vertex(CornerId c) const { return VertexId{corner_vertex_[c.index()]}; }
    /// Of all corners, face after face.
    [[nodiscard]] std::span<const std::int32_t> face_vertices() const { return corner_vertex_; }
    [[nodiscard]] EdgeId edge(CornerId c) const { return EdgeId{corner_edge_[c.index()]}; }
    [[nodiscard]] FaceId face(CornerId c) const { return FaceId{corner_face_[c.index()]}; }
    [[nodiscard]] CornerId next(CornerId c) const {
        if (all_quads_) return CornerId{(c.value & ~3) | ((c.value + 1) & 3)};
        const auto range = corners(face(c));
        return c.value + 1 == range[range.size()].value ? range[0] : CornerId{c.value + 1};
    }
    [[nodiscard]] CornerId previous(CornerId c) const {
        if (all_quads_) return CornerId{(c.value & ~3) | ((c.value + 3) & 3)};
        const auto range = corners(face(c));
        return c == range[0] ? range[range.size() - 1] : CornerId{c.value - 1};
    }
    /// The opposite half-edge; not valid() on the boundary.
    [[nodiscard]] CornerId twin(CornerId c) const { return CornerId{corner_twin_[c.index()]}; }
    /// The next half-edge that leaves the same vertex, counter-clockwise; not valid() at the
    /// boundary.
    [[nodiscard]] CornerId rotate(CornerId c) const { return twin(previous(c)); }

    /// A half-edge of the edge: the one with the lower corner number.
    [[nodiscard]] CornerId corner(EdgeId e) const { return CornerId{edge_corner_[e.index()]}; }
    [[nodiscard]] VertexId start(EdgeId e) const { return vertex(corner(e)); }
    [[nodiscard]] VertexId end(EdgeId e) const { return vertex(next(corner(e))); }
    [[nodiscard]] bool is_boundary(EdgeId e) const { return !twin(corner(e)).valid(); }

    /// A half-edge that leaves the vertex; at a boundary the one from which rotate() meets all
    /// faces.
    [[nodiscard]] CornerId corner(VertexId v) const { return CornerId{vertex_corner_[v.index()]}; }
    [[nodiscard]] bool is_boundary(VertexId v) const { return is_boundary(edge(corner(v))); }
    [[nodiscard]] int face_valence(VertexId v) const;
    /// Number of edges at the vertex.
    [[nodiscard]] int valence(VertexId v) const {
        return face_valence(v) + (is_boundary(v) ? 1 : 0);
    }

    /// Sharpness as it acts: infinite on the boundary, else the tag's value.
    [[nodiscard]] double sharpness(EdgeId e) const {
        return is_boundary(e) ? infinite_sharpness : edge_sharpness_[e.index()];
    }
    /// Sharpness as it acts: infinite at corners that the boundary rule makes, else the tag's
    /// value.
    [[nodiscard]] double sharpness(VertexId v) const;
    [[nodiscard]] double tagged_sharpness(EdgeId e) const { return edge_sharpness_[e.index()]; }
    [[nodiscard]] double tagged_sharpness(VertexId v) const { return vertex_sharpness_[v.index()]; }
    [[nodiscard]] BoundaryRule boundary_rule() const { return boundary_rule_; }

    [[nodiscard]] const std::vector<SectorTagInput>& sectors() const { return sectors_; }
    /// How far the edge point is moved towards the end of this half-edge, as a share of its length.
    [[nodiscard]] double edge_shift(CornerId c) const {
        return is_shifted(c) ? edge_shift_[c.index()] : 0.0;
    }
    /// Whether a sector's angle, and be it with a shift of 0, makes the rule at this half-edge.
    [[nodiscard]] bool is_shifted(CornerId c) const {
        return !edge_shift_.empty() && c.valid() && !std::isnan(edge_shift_[c.index()]);
    }
    [[nodiscard]] bool has_edge_shifts() const { return !edge_shift_.empty(); }

    [[nodiscard]] CreaseRule crease_rule() const { return crease_rule_; }
    /// The same mesh with another rule at creases.
    [[nodiscard]] Topology with(CreaseRule rule) const;
    /// Whether CreaseRule::ParabolicRunout acts anywhere.
    [[nodiscard]] bool has_runouts() const { return !runouts_.empty(); }
    /// Whether the line of control points along this edge has a parabolic runout at `v`, its end.
    [[nodiscard]] bool is_runout(EdgeId e, VertexId v) const {
        return has_runouts() && (runouts_[e.index()] & (v == start(e) ? 1 : 2)) != 0;
    }
    /// Whether a runout may act on the face, which is regular then.
    [[nodiscard]] bool is_near_runout(FaceId f) const {
        return has_runouts() && near_runout_[f.index()] != 0;
    }

    [[nodiscard]] bool is_pinned(VertexId v) const { return pinned_[v.index()] != 0; }
    [[nodiscard]] int group(FaceId f) const {
        return face_group_.empty() ? -1 : face_group_[f.index()];
    }
    [[nodiscard]] const std::vector<std::string>& group_names() const { return group_names_; }

    [[nodiscard]] bool all_quads() const { return all_quads_; }
    [[nodiscard]] bool is_closed() const { return closed_; }

  private:
    void connect();
    void shift_edge(CornerId c, double shift);
    void set_crease_rule(CreaseRule rule);

    std::vector<std::int32_t> face_begin_;     // faces + 1
    std::vector<std::int32_t> corner_vertex_;  // corners
    std::vector<std::int32_t> corner_face_;
    std::vector<std::int32_t> corner_edge_;
    std::vector<std::int32_t> corner_twin_;
    std::vector<std::int32_t> edge_corner_;    // edges
    std::vector<std::int32_t> vertex_corner_;  // vertices
    std::vector<double> edge_sharpness_;
    std::vector<double> vertex_sharpness_;
    std::vector<SectorTagInput> sectors_;
    std::vector<double> edge_shift_;  // corners, NaN where there is none; or empty
    std::vector<char> pinned_;
    std::vector<std::int32_t> face_group_;
    std::vector<std::string> group_names_;
    BoundaryRule boundary_rule_ = BoundaryRule::EdgeOnly;
    CreaseRule crease_rule_ = CreaseRule::CatmullClark;
    std::vector<std::uint8_t> runouts_;  // edges, bit 0: at start, 1: at end; or empty
    std::vector<char> near_runout_;      // faces, or empty
    bool all_quads_ = true;
    bool closed_ = true;
};

/// The half-edges that leave `c`'s vertex, one a face, of the faces between two infinitely sharp
/// edges that `c`'s face lies in, counter-clockwise; none where sharp edges do not bound them.
std::vector<CornerId> sector_corners(const Topology& topology, CornerId c);

/// The corner of face `f` at vertex `v`; not valid() when there is none.
CornerId find_corner(const Topology& topology, FaceId f, VertexId v);

}  // namespace patchwright::mesh
#pragma GCC visibility pop
