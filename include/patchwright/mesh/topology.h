// The connectivity of a control mesh with its subdivision tags; holds no positions.
#pragma once

#include <patchwright/base/ids.h>

#include <array>
#include <cmath>
#include <limits>
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

inline constexpr double infinite_sharpness = std::numeric_limits<double>::infinity();

/// What happens at the boundary; the values are those of OpenSubdiv's `interpolateboundary` tag.
enum class BoundaryRule {
    EdgeOnly = 1,      ///< boundary edges are creases
    EdgeAndCorner = 2  ///< and boundary vertices with one face are corners
};

struct EdgeTagInput {
    int v0, v1;
    double sharpness;
};

struct VertexTagInput {
    int vertex;
    double sharpness;
};

/// The faces between two infinitely sharp edges at a vertex whose shape is to be controlled.
struct SectorTagInput {
    int vertex;
    int face;  ///< any of the sector's
    /// What the sector spans, radians in (0, 2 pi): edge points near the vertex then follow the
    /// rule for that angle. 0: the ordinary rules.
    double angle = 0.0;
    std::array<double, 3> normal{};  ///< of the surface there; zero: free
};

/// The point of an edge is moved by shift * (v1 - v0) at every step; goes on with the half at v0.
struct EdgeShiftInput {
    int v0, v1;
    double shift;
};

/// Lines of a file, one an element, that messages name.
struct SourceLines {
    std::vector<int> vertices, faces, creases, corners, sectors, pins;
};

/// Polygons and tags as a file or a program gives them, unchecked.
struct TopologyInput {
    int vertex_count = 0;
    std::vector<int> face_sizes;     ///< one a face
    std::vector<int> face_vertices;  ///< face after face, counter-clockwise seen from outside
    std::vector<EdgeTagInput> creases;
    std::vector<VertexTagInput> corners;
    std::vector<SectorTagInput> sectors;
    std::vector<EdgeShiftInput> edge_shifts;  ///< besides those that sectors make
    std::vector<int> pins;                    ///< vertices whose control points a fit must not move
    std::vector<int> face_group;  ///< one a face, index into group_names; or empty: no names
    std::vector<std::string> group_names;
    BoundaryRule boundary_rule = BoundaryRule::EdgeOnly;
    SourceLines lines;  ///< empty: not from a file
};

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
    bool all_quads_ = true;
    bool closed_ = true;
};

/// The half-edges that leave `c`'s vertex, one a face, of the faces between two infinitely sharp
/// edges that `c`'s face lies in, counter-clockwise; none where sharp edges do not bound them.
std::vector<CornerId> sector_corners(const Topology& topology, CornerId c);

/// The corner of face `f` at vertex `v`; not valid() when there is none.
CornerId find_corner(const Topology& topology, FaceId f, VertexId v);

/// Sharpness of at least this counts as infinite, as in OpenSubdiv.
inline constexpr double sharpness_limit = 10.0;

}  // namespace patchwright::mesh
#pragma GCC visibility pop
