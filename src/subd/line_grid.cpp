#include "subd/line_grid.h"

#include <patchwright/mesh/regular.h>
#include <patchwright/subd/ring.h>

#include <algorithm>

namespace patchwright::subd {

namespace {

using mesh::CornerId;
using mesh::Topology;

bool is_own(int a, int b) { return (a == 1 || a == 2) && (b == 1 || b == 2); }

}  // namespace

LineGrid::LineGrid(const Topology& topology, mesh::FaceId face) : topology_(topology) {
    const CornerId origin = topology.corners(face)[0];
    const auto sharp = [&](CornerId c) { return mesh::is_sharp(topology, topology.edge(c)); };
    end(V, 0).crease = sharp(origin);
    end(U, 1).crease = sharp(topology.next(origin));
    end(V, 1).crease = sharp(topology.next(topology.next(origin)));
    end(U, 0).crease = sharp(topology.previous(origin));
    find_cells(origin);
    vertex_.fill(-1);
    for (int a = place(U, 0); a <= place(U, 1); ++a)
        for (int b = place(V, 0); b <= place(V, 1); ++b) vertex(a, b) = find_vertex(a, b);
    for (const Direction along : {U, V}) {
        const Direction across = along == U ? V : U;
        for (int side = 0; side < 2; ++side) {
            const int at = place(along, side), next = side == 0 ? at + 1 : at - 1;
            for (int line = place(across, 0); line <= place(across, 1); ++line)
                end(along, side).runout[std::size_t(line)] = has_runout(along, at, next, line);
        }
    }
}

void LineGrid::find_cells(CornerId origin) {
    const Topology& t = topology_;
    cell(0, 0) = origin;
    if (!end(U, 0).crease) cell(-1, 0) = mesh::left_of(t, origin);
    if (!end(U, 1).crease) cell(1, 0) = mesh::right_of(t, origin);
    for (int i = -1; i <= 1; ++i) {
        if (!cell(i, 0).valid()) continue;
        if (!end(V, 0).crease) cell(i, -1) = mesh::below(t, cell(i, 0));
        if (!end(V, 1).crease) cell(i, 1) = mesh::above(t, cell(i, 0));
    }
}

std::int32_t LineGrid::find_vertex(int a, int b) const {
    const bool right = a > 1, top = b > 1;
    CornerId c = cell(right ? a - 2 : a - 1, top ? b - 2 : b - 1);
    if (right && top) c = topology_.next(topology_.next(c));
    if (right && !top) c = topology_.next(c);
    if (!right && top) c = topology_.previous(c);
    return topology_.vertex(c).value;
}

/// Whether the line that goes on to place `towards` has a runout at place `at`.
bool LineGrid::has_runout(Direction along, int at, int towards, int line) const {
    // The cell between the two places, on one side of the line, and its edge there.
    const bool far = line > 1;
    const int between = std::min(at, towards) - 1, beside = far ? line - 2 : line - 1;
    const CornerId c = along == U ? cell(between, beside) : cell(beside, between);
    const CornerId side = along == U ? (far ? topology_.next(topology_.next(c)) : c)
                                     : (far ? topology_.next(c) : topology_.previous(c));
    const std::int32_t v = along == U ? vertex(at, line) : vertex(line, at);
    return topology_.is_runout(topology_.edge(side), mesh::VertexId{v});
}

std::vector<std::int32_t> LineGrid::vertices() const {
    std::vector<std::int32_t> result;
    for (const auto& [a, b] : own_places) result.push_back(vertex(a, b));
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b)
            if (vertex(a, b) >= 0 && !is_own(a, b)) result.push_back(vertex(a, b));
    return result;
}

std::string LineGrid::key() const {
    std::string key(1, '\0');  // no face has so many corners
    for (const End& end : ends_) {
        key.push_back(end.crease ? 'c' : 's');
        for (const bool runout : end.runout) key.push_back(runout ? '1' : '0');
    }
    return key;
}

Eigen::MatrixXd LineGrid::control_points() const {
    const auto count = Eigen::Index(vertices().size());
    Eigen::MatrixXd grid = Eigen::MatrixXd::Zero(16, count);
    const auto control = [&](Direction along, int place, int line) {
        return along == U ? grid.row(4 * place + line) : grid.row(4 * line + place);
    };
    for (Eigen::Index i = 0; i < 4; ++i)
        grid(4 * own_places[std::size_t(i)][0] + own_places[std::size_t(i)][1], i) = 1.0;
    Eigen::Index slot = 4;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b)
            if (vertex(a, b) >= 0 && !is_own(a, b)) grid(4 * a + b, slot++) = 1.0;
    const Eigen::MatrixXd vertices = grid;
    const auto vertex_at = [&](Direction along, int place, int line) {
        return vertices.row(along == U ? 4 * place + line : 4 * line + place);
    };

    // Mirrors rows beyond the creases at either end of the lines in this direction.
    const auto mirror = [&](Direction along, const auto& row) {
        if (end(along, 0).crease) row(0) = 2.0 * row(1) - row(2);
        if (end(along, 1).crease) row(3) = 2.0 * row(2) - row(1);
    };
    for (int line = 0; line < 4; ++line)
        mirror(U, [&](int place) { return control(U, place, line); });
    for (int line = 0; line < 4; ++line)
        mirror(V, [&](int place) { return control(V, place, line); });
    for (const Direction along : {U, V}) {
        for (int side = 0; side < 2; ++side) {
            const int at = place(along, side), step = side == 0 ? 1 : -1;
            // From the vertex at the end to the control point there: the third differences of the
            // line's control points vanish, and its limit at the crease is that of the crease.
            Eigen::MatrixXd difference = Eigen::MatrixXd::Zero(4, count);
            for (int line = 0; line < 4; ++line) {
                if (!end(along, side).runout[std::size_t(line)]) continue;
                difference.row(line) =
                    (2.0 * vertex_at(along, at + step, line) - vertex_at(along, at, line) -
                     vertex_at(along, at + 2 * step, line)) /
                    7.0;
            }
            mirror(along == U ? V : U, [&](int line) { return difference.row(line); });
            for (int line = 0; line < 4; ++line) {
                control(along, at, line) += difference.row(line);
                if (end(along, side).crease)
                    control(along, at - step, line) -= 4.0 * difference.row(line);
            }
        }
    }
    return grid;
}

}  // namespace patchwright::subd
