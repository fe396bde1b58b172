#include "mesh/runouts.h"

#include <patchwright/mesh/regular.h>

#include <array>

namespace patchwright::mesh {

namespace {

/// Whether the face is one polynomial as seen from its own corner `c`.
bool is_regular_corner(const Topology& t, CornerId c) {
    const VertexId v = t.vertex(c);
    int smooth_spokes = 0, sharp_spokes = 0;
    CornerId spoke = t.corner(v);
    const CornerId first = spoke;
    do {
        const double s = t.sharpness(t.edge(spoke));
        if (s > 0.0 && !std::isinf(s)) return false;
        if (t.is_shifted(spoke) || t.is_shifted(t.twin(spoke))) return false;
        if (t.size(t.face(spoke)) != 4) return false;
        (s > 0.0 ? sharp_spokes : smooth_spokes) += 1;
        spoke = t.rotate(spoke);
        if (!spoke.valid()) ++sharp_spokes;  // the other boundary edge
    } while (spoke.valid() && spoke != first);

    const double s = t.sharpness(v);
    if (s > 0.0 && !std::isinf(s)) return false;
    const bool corner = s > 0.0 || sharp_spokes > 2;
    const bool leaving = is_sharp(t, t.edge(c));
    const bool arriving = is_sharp(t, t.edge(t.previous(c)));
    if (leaving && arriving) return corner;
    if (corner) return false;
    if (!leaving && !arriving) return sharp_spokes == 0 && smooth_spokes == 4;
    // A crease vertex: regular when just one more face lies between the face and the other crease
    // edge.
    if (sharp_spokes != 2) return false;
    if (leaving) return is_sharp(t, t.edge(t.previous(t.twin(t.previous(c)))));
    return is_sharp(t, t.edge(t.next(t.twin(c))));
}

/// The two directions of a quad that is given by the corner at its lowest u and v.
enum class Along { U, V };

class RunoutFinder {
  public:
    explicit RunoutFinder(const Topology& t)
        : t_(t),
          regular_(std::size_t(t.face_count()), 0),
          of_edge_(std::size_t(t.edge_count()), 0) {
        for (const FaceId f : t.faces()) regular_[f.index()] = is_regular(t, f) ? 1 : 0;
    }

    Runouts find() {
        // A crease belongs to one side or two, and its end to all of them.
        std::vector<int> sides(2 * of_edge_.size(), 0);
        for (std::int32_t i = 0; i < t_.corner_count(); ++i) {
            const CornerId cell{i};
            if (!is_regular_cell(cell) || !sharp(cell)) continue;
            const CornerId beside = t_.previous(cell);
            if (!sharp(beside)) {
                if (is_inner_end(cell)) set(t_.edge(beside), t_.vertex(cell));
                continue;
            }
            for (const Along along : {Along::U, Along::V}) {
                if (!is_crease_end(cell, along)) continue;
                const EdgeId e = t_.edge(along == Along::U ? cell : beside);
                int& willing = sides[2 * e.index() + (t_.vertex(cell) == t_.start(e) ? 0 : 1)];
                if (++willing == (t_.is_boundary(e) ? 1 : 2)) set(e, t_.vertex(cell));
            }
        }
        std::vector<char> near = faces_near_ends();
        if (near.empty()) return {};
        return {std::move(of_edge_), std::move(near)};
    }

  private:
    [[nodiscard]] bool sharp(CornerId c) const { return is_sharp(t_, t_.edge(c)); }
    [[nodiscard]] bool is_regular_cell(CornerId c) const {
        return regular_[t_.face(c).index()] != 0;
    }
    void set(EdgeId e, VertexId v) {
        of_edge_[e.index()] |= std::uint8_t(v == t_.start(e) ? 1 : 2);
    }

    // Steps of cells, not valid() across sharp edges.
    [[nodiscard]] CornerId right(CornerId c) const {
        return sharp(t_.next(c)) ? CornerId{} : right_of(t_, c);
    }
    [[nodiscard]] CornerId left(CornerId c) const {
        return sharp(t_.previous(c)) ? CornerId{} : left_of(t_, c);
    }
    [[nodiscard]] CornerId up(CornerId c) const {
        return sharp(t_.next(t_.next(c))) ? CornerId{} : above(t_, c);
    }
    [[nodiscard]] CornerId on(CornerId c, Along along) const {
        return along == Along::U ? right(c) : up(c);
    }

    /// Whether the line at the left of a cell above a crease may end there by the rule.
    [[nodiscard]] bool is_inner_end(CornerId cell) const {
        const std::array<CornerId (RunoutFinder::*)(CornerId) const, 2> sideways{
            &RunoutFinder::right, &RunoutFinder::left};
        const std::array<CornerId, 2> beside{cell, left(cell)};
        for (std::size_t side = 0; side < 2; ++side) {
            CornerId column = beside[side];
            for (int i = 0; i < 2 && column.valid(); ++i) {
                const CornerId second = up(column);
                if (!is_regular_cell(column) || !second.valid() || !is_regular_cell(second))
                    return false;
                column = (this->*sideways[side])(column);
            }
            // The line's third vertex is on no other crease.
            if (sharp(t_.next(t_.next(up(beside[side]))))) return false;
        }
        return true;
    }

    /// Whether a crease at a corner may end there by the rule, as far as this side is concerned.
    [[nodiscard]] bool is_crease_end(CornerId cell, Along along) const {
        const Along beside = along == Along::U ? Along::V : Along::U;
        CornerId c = cell;
        for (int i = 0; i < 2; ++i, c = on(c, along)) {
            if (!c.valid() || !is_regular_cell(c)) return false;
            const CornerId next_row = on(c, beside);
            if (next_row.valid() && !is_regular_cell(next_row)) return false;
        }
        return c.valid();
    }

    /// Regular faces up to the second row around the ends; empty where there are none.
    [[nodiscard]] std::vector<char> faces_near_ends() const {
        std::vector<char> near_vertex(std::size_t(t_.vertex_count()), 0);
        bool any = false;
        for (const EdgeId e : t_.edges()) {
            if ((of_edge_[e.index()] & 1) != 0) near_vertex[t_.start(e).index()] = 1;
            if ((of_edge_[e.index()] & 2) != 0) near_vertex[t_.end(e).index()] = 1;
            any = any || of_edge_[e.index()] != 0;
        }
        if (!any) return {};
        std::vector<char> near(regular_.size(), 0);
        for (int row = 0; row < 2; ++row) {
            for (const FaceId f : t_.faces())
                for (const CornerId c : t_.corners(f))
                    if (near_vertex[t_.vertex(c).index()] != 0) near[f.index()] = 1;
            for (const FaceId f : t_.faces())
                if (near[f.index()] != 0)
                    for (const CornerId c : t_.corners(f)) near_vertex[t_.vertex(c).index()] = 1;
        }
        for (std::size_t f = 0; f < near.size(); ++f)
            if (regular_[f] == 0) near[f] = 0;
        return near;
    }

    const Topology& t_;
    std::vector<char> regular_;
    std::vector<std::uint8_t> of_edge_;
};

}  // namespace

bool is_regular(const Topology& t, FaceId f) {
    if (t.size(f) != 4) return false;
    for (const CornerId c : t.corners(f))
        if (!is_regular_corner(t, c)) return false;
    return true;
}

Runouts find_runouts(const Topology& t) {
    // Meshes of other polygons are refined before patches and grids are made of them.
    if (!t.all_quads()) return {};
    return RunoutFinder(t).find();
}

}  // namespace patchwright::mesh
