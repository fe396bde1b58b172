#include <patchwright/subd/refine.h>
#include <patchwright/subd/ring.h>

#include <algorithm>

namespace patchwright::subd {

namespace {

using mesh::CornerId;
using mesh::EdgeId;
using mesh::FaceId;
using mesh::Topology;
using mesh::VertexId;

double child_sharpness(double parent) { return std::max(parent - 1.0, 0.0); }

/// Which of a vertex's sharp edges act, at this level or at the next one.
struct VertexFeatures {
    double sharpness;
    int sharp_edges;

    [[nodiscard]] bool is_corner() const { return sharpness > 0.0 || sharp_edges > 2; }
    [[nodiscard]] bool is_crease() const { return !is_corner() && sharp_edges == 2; }
    [[nodiscard]] bool is_smooth() const { return !is_corner() && sharp_edges < 2; }
    [[nodiscard]] bool same_rule(const VertexFeatures& other) const {
        return is_corner() == other.is_corner() && is_crease() == other.is_crease();
    }
};

class StencilBuilder {
  public:
    explicit StencilBuilder(const Topology& topology) : topology_(topology) {}

    Stencils build() {
        Stencils stencils;
        stencils.columns = topology_.vertex_count();
        const auto rows =
            std::size_t(topology_.vertex_count() + topology_.edge_count() + topology_.face_count());
        stencils.begin.reserve(rows + 1);
        stencils.index.reserve(7 * rows);
        stencils.weight.reserve(7 * rows);
        for (const VertexId v : topology_.vertices()) {
            vertex_point(v);
            row_.flush(stencils);
        }
        for (const EdgeId e : topology_.edges()) {
            edge_point(e);
            row_.flush(stencils);
        }
        for (const FaceId f : topology_.faces()) {
            add_face_point(f, 1.0);
            row_.flush(stencils);
        }
        return stencils;
    }

  private:
    /// Adds the control point that corner `c` of a face stands for: its vertex, but for those at
    /// runouts.
    void add_control_point(CornerId c, double weight) {
        add_near_runout(c, weight, [](const Eigen::MatrixXd& grid, int a, int b) {
            return Eigen::RowVectorXd(grid.row(4 * a + b));
        });
    }

    /// Adds the control point, as that of a curve, of the crease along half-edge `c` at its start,
    /// or at its end.
    void add_crease_point(CornerId c, bool at_end, double weight) {
        const int side = c.value - topology_.corners(topology_.face(c))[0].value;
        add_near_runout(
            at_end ? topology_.next(c) : c, weight, [&](const Eigen::MatrixXd& grid, int a, int b) {
                // The limit across the crease, which is along u or along v.
                const int step = side % 2 == 0 ? 1 : 4, at = 4 * a + b;
                return Eigen::RowVectorXd(
                    (grid.row(at - step) + 4.0 * grid.row(at) + grid.row(at + step)) / 6.0);
            });
    }

    /// @param row_at  coefficients over the ring's slots at place (a, b) of its control points
    template <class RowAt>
    void add_near_runout(CornerId c, double weight, const RowAt& row_at) {
        const FaceId f = topology_.face(c);
        if (!topology_.is_near_runout(f)) {
            row_.add(topology_.vertex(c).value, weight);
            return;
        }
        const auto& [a, b] = own_places[std::size_t(c.value - topology_.corners(f)[0].value)];
        const Ring ring = table_.ring(topology_, f);
        const Eigen::RowVectorXd row = row_at(ring.kind->regular(), a, b);
        for (std::size_t slot = 0; slot < ring.vertices.size(); ++slot)
            if (row[Eigen::Index(slot)] != 0.0)
                row_.add(ring.vertices[slot], weight * row[Eigen::Index(slot)]);
    }

    void add_face_point(FaceId f, double weight) {
        const auto corners = topology_.corners(f);
        for (const CornerId c : corners) add_control_point(c, weight / corners.size());
    }

    void edge_point(EdgeId e) {
        const double sharp = std::min(topology_.sharpness(e), 1.0);
        const double end_weight = 0.5 * sharp + 0.25 * (1.0 - sharp);
        const CornerId c = topology_.corner(e);
        if (sharp == 1.0) {
            add_crease_point(c, false, end_weight);
            add_crease_point(c, true, end_weight);
        } else {
            add_control_point(c, end_weight);
            add_control_point(topology_.next(c), end_weight);
            add_face_point(topology_.face(c), 0.25 * (1.0 - sharp));
            add_face_point(topology_.face(topology_.twin(c)), 0.25 * (1.0 - sharp));
        }
        if (topology_.has_edge_shifts()) {
            const CornerId d = topology_.twin(c);
            const double shift =
                topology_.edge_shift(c) - (d.valid() ? topology_.edge_shift(d) : 0.0);
            row_.add(topology_.end(e).value, shift);
            row_.add(topology_.start(e).value, -shift);
        }
    }

    /// Calls `visit(a half-edge, whether it leaves the vertex)` for every edge at the vertex.
    template <class Visit>
    void for_edges(VertexId v, Visit&& visit) const {
        const CornerId first = topology_.corner(v);
        for (CornerId c = first;;) {
            visit(c, true);
            const CornerId arriving = topology_.previous(c);
            c = topology_.twin(arriving);
            if (!c.valid()) {
                visit(arriving, false);
                return;
            }
            if (c == first) return;
        }
    }

    void vertex_point(VertexId v) {
        VertexFeatures now{topology_.sharpness(v), 0};
        VertexFeatures then{child_sharpness(now.sharpness), 0};
        double ending_sum = 0.0;
        int ending_count = 0;
        const auto note_end = [&](double sharpness) {
            if (sharpness > 0.0 && child_sharpness(sharpness) == 0.0) {
                ending_sum += sharpness;
                ++ending_count;
            }
        };
        note_end(now.sharpness);
        for_edges(v, [&](CornerId c, bool) {
            const double s = topology_.sharpness(topology_.edge(c));
            if (s > 0.0) ++now.sharp_edges;
            if (child_sharpness(s) > 0.0) ++then.sharp_edges;
            note_end(s);
        });
        if (now.same_rule(then)) {
            add_vertex_mask(v, now, 0.0, 1.0);
            return;
        }
        const double weight = std::min(ending_sum / ending_count, 1.0);
        add_vertex_mask(v, now, 0.0, weight);
        if (weight < 1.0) add_vertex_mask(v, then, 1.0, 1.0 - weight);
    }

    /// @param beyond  edges of at most this sharpness count as smooth
    void add_vertex_mask(VertexId v, const VertexFeatures& features, double beyond, double weight) {
        if (features.is_corner()) {
            row_.add(v.value, weight);
        } else if (features.is_crease()) {
            row_.add(v.value, 0.75 * weight);
            for_edges(v, [&](CornerId c, bool leaves) {
                if (topology_.sharpness(topology_.edge(c)) > beyond)
                    add_crease_point(c, leaves, 0.125 * weight);
            });
        } else {
            const int n = topology_.valence(v);
            row_.add(v.value, weight * (n - 2.0) / n);
            for_edges(v, [&](CornerId c, bool leaves) {
                add_control_point(leaves ? topology_.next(c) : c, weight / (n * n));
            });
            const CornerId first = topology_.corner(v);
            CornerId c = first;
            do {
                add_face_point(topology_.face(c), weight / (n * n));
                c = topology_.rotate(c);
            } while (c != first);
        }
    }

    const Topology& topology_;
    RingTable table_;
    StencilRow row_;
};

mesh::TopologyInput refined_input(const Topology& t) {
    mesh::TopologyInput fine;
    const int edge_base = t.vertex_count();
    const int face_base = edge_base + t.edge_count();
    fine.vertex_count = face_base + t.face_count();
    fine.face_sizes.assign(std::size_t(t.corner_count()), 4);
    fine.face_vertices.reserve(4 * std::size_t(t.corner_count()));
    fine.group_names = t.group_names();
    fine.boundary_rule = t.boundary_rule();
    // The limit surface stays.
    if (t.has_runouts()) fine.crease_rule = t.crease_rule();
    for (const FaceId f : t.faces()) {
        const auto corners = t.corners(f);
        const int n = corners.size();
        for (int i = 0; i < n; ++i) {
            const int child[4] = {t.vertex(corners[i]).value, edge_base + t.edge(corners[i]).value,
                                  face_base + f.value,
                                  edge_base + t.edge(corners[(i + n - 1) % n]).value};
            const int turn = n == 4 ? 4 - i : 0;
            for (int k = 0; k < 4; ++k) fine.face_vertices.push_back(child[(turn + k) % 4]);
            if (!t.group_names().empty()) fine.face_group.push_back(t.group(f));
        }
    }
    for (const EdgeId e : t.edges()) {
        const double sharpness = child_sharpness(t.tagged_sharpness(e));
        if (sharpness > 0.0) {
            fine.creases.push_back({t.start(e).value, edge_base + e.value, sharpness});
            fine.creases.push_back({edge_base + e.value, t.end(e).value, sharpness});
        }
    }
    for (const VertexId v : t.vertices()) {
        const double sharpness = child_sharpness(t.tagged_sharpness(v));
        if (sharpness > 0.0) fine.corners.push_back({v.value, sharpness});
        if (t.is_pinned(v)) fine.pins.push_back(v.value);
    }
    for (const mesh::SectorTagInput& tag : t.sectors()) {
        // Child k of a face is numbered like the face's corner k.
        const CornerId c = mesh::find_corner(t, FaceId{tag.face}, VertexId{tag.vertex});
        fine.sectors.push_back({tag.vertex, c.value, tag.angle, tag.normal});
    }
    for (const FaceId f : t.faces()) {
        for (const CornerId c : t.corners(f)) {
            if (t.is_shifted(c)) {
                fine.edge_shifts.push_back(
                    {t.vertex(c).value, edge_base + t.edge(c).value, t.edge_shift(c)});
            }
        }
    }
    return fine;
}

}  // namespace

Refinement refine(const Topology& topology) {
    return {std::make_shared<const Topology>(refined_input(topology)),
            StencilBuilder(topology).build()};
}

mesh::Cage refine(const mesh::Cage& cage, int levels) {
    mesh::Cage fine = cage;
    for (int level = 0; level < levels; ++level) {
        Refinement step = refine(*fine.topology);
        fine = {std::move(step.topology), step.stencils.apply(fine.points)};
    }
    return fine;
}

}  // namespace patchwright::subd
