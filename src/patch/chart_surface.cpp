#include "patch/chart_surface.h"

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <cmath>

namespace patchwright::patch {

namespace {

using mesh::CornerId;
using mesh::Topology;

/// Inner knots of a chart in both directions, as they are found.
struct KnotCollector {
    std::map<double, int> u, v;  // multiplicity of each

    void add(std::map<double, int>& knots, double at, int multiplicity) {
        int& known = knots[at];
        known = std::max(known, multiplicity);
    }
};

const Cap* cap_at(const SurfaceSource& source, CornerId c, std::size_t* place = nullptr) {
    const auto found = source.cap_at.find(c.value);
    if (found == source.cap_at.end()) return nullptr;
    if (place != nullptr) *place = std::size_t(found->second.second);
    return &source.caps[std::size_t(found->second.first)];
}

/// Parameters (u, v) of a face, seen from its corner i.
Eigen::Vector2d seen_parameters(int i, double u, double v) {
    switch (i) {
        case 0: return {u, v};
        case 1: return {v, 1.0 - u};
        case 2: return {1.0 - u, 1.0 - v};
        default: return {1.0 - v, u};
    }
}

void collect_knots(const SurfaceSource& source, CornerId cell, int column, int row,
                   KnotCollector& knots) {
    const Topology& t = *source.cage.topology;
    const auto face = t.face(cell);
    const subd::RingKind& kind = *source.kinds[face.index()];
    if (kind.is_regular()) return;
    const int turn = position(t, cell);
    const auto add = [&](const Eigen::Vector2d& at, int multiplicity, bool along_u) {
        if (along_u) knots.add(knots.u, column + at.x(), multiplicity);
        if (!along_u) knots.add(knots.v, row + at.y(), multiplicity);
    };
    const bool swapped = turn % 2 == 1;
    const Splits inside = splits(kind);
    for (const double u : inside.u) add(seen_parameters(turn, u, 0.0), 1, !swapped);
    for (const double v : inside.v) add(seen_parameters(turn, 0.0, v), 1, swapped);
    for (int i = 0; i < 4; ++i) {
        const Cap* cap = cap_at(source, t.corners(face)[i]);
        if (cap == nullptr) continue;
        const std::vector<double> near = cap->knots(steps_to_one_corner(kind, i));
        for (auto k = near.begin(); k != near.end();) {
            const auto end = std::upper_bound(k, near.end(), *k);
            // The same distance along both edges at the corner.
            const double u = subd::at_end_u(i) ? 1.0 - *k : *k;
            const double v = subd::at_end_v(i) ? 1.0 - *k : *k;
            add(seen_parameters(turn, u, 0.0), int(end - k), !swapped);
            add(seen_parameters(turn, 0.0, v), int(end - k), swapped);
            k = end;
        }
    }
}

std::vector<double> flat_knots(const std::map<double, int>& inner, int length) {
    std::vector<double> knots(4, 0.0);
    auto next = inner.upper_bound(0.0);
    for (; next != inner.end() && next->first < length; ++next) {
        knots.insert(knots.end(), std::size_t(next->second), next->first);
    }
    knots.insert(knots.end(), 4, double(length));
    return knots;
}

/// A control point's place in one direction: the blossom's arguments, and the middle of a knot
/// interval in the point's support, from whose piece it is taken.
struct Slot {
    Eigen::Vector3d arguments;
    double middle;
};

std::vector<Slot> slots_of(const std::vector<double>& knots) {
    std::vector<Slot> slots(knots.size() - 4);
    for (std::size_t i = 0; i < slots.size(); ++i) {
        // The larger of the two middle intervals: the arguments lie at its ends or beyond by the
        // least shares of it. At the ends of the range both are empty.
        constexpr int order[] = {1, 2, 0, 3};
        double size = 0.0;
        Slot& slot = slots[i];
        for (const int k : order) {
            const double from = knots[i + std::size_t(k)], to = knots[i + std::size_t(k) + 1];
            if (to - from > size && (size == 0.0 || k == 2)) {
                size = to - from;
                slot.middle = 0.5 * (from + to);
            }
        }
        slot.arguments = {knots[i + 1], knots[i + 2], knots[i + 3]};
    }
    return slots;
}

/// All pieces of a cell's face in the chart's orientation, the cell's origin at (0, 0).
std::vector<PolynomialPiece> cell_pieces(const SurfaceSource& source, CornerId cell) {
    const Topology& t = *source.cage.topology;
    const auto face = t.face(cell);
    const subd::Ring ring = source.table.ring(t, face);
    std::array<int, 4> hole{};
    std::vector<PolynomialPiece> pieces;
    if (!ring.kind->is_regular()) {
        for (int i = 0; i < 4; ++i) {
            std::size_t place = 0;
            const Cap* cap = cap_at(source, t.corners(face)[i], &place);
            if (cap == nullptr) continue;
            hole[std::size_t(i)] = cap->hole;
            pieces.insert(pieces.end(), cap->pieces[place].begin(), cap->pieces[place].end());
        }
    }
    const std::vector<PolynomialPiece> regular = regular_pieces(ring, source.cage.points, hole);
    pieces.insert(pieces.end(), regular.begin(), regular.end());
    for (PolynomialPiece& piece : pieces) piece = seen_from(piece, position(t, cell));
    return pieces;
}

/// First slot of each unit interval [k, k + 1], with one more at the end.
std::vector<std::size_t> first_slots(const std::vector<Slot>& slots, int length) {
    std::vector<std::size_t> first;
    std::size_t at = 0;
    for (int k = 0; k <= length; ++k) {
        while (at < slots.size() && slots[at].middle < k) ++at;
        first.push_back(at);
    }
    return first;
}

}  // namespace

geom::BsplineSurface chart_surface(const Chart& chart, const SurfaceSource& source) {
    KnotCollector knots;
    for (int i = 1; i < chart.columns; ++i) knots.u[i] = 1;
    for (int j = 1; j < chart.rows; ++j) knots.v[j] = 1;
    for (int i = 0; i < chart.columns; ++i) {
        for (int j = 0; j < chart.rows; ++j) collect_knots(source, chart.cell(i, j), i, j, knots);
    }
    geom::BsplineSurface surface{
        flat_knots(knots.u, chart.columns), flat_knots(knots.v, chart.rows), {}};
    surface.points.resize(surface.rows() * surface.columns(), 3);

    const std::vector<Slot> u = slots_of(surface.knots_u), v = slots_of(surface.knots_v);
    const auto first_u = first_slots(u, chart.columns), first_v = first_slots(v, chart.rows);
    base::parallel_for(chart.cells.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t cell = begin; cell < end; ++cell) {
            const std::size_t column = cell / std::size_t(chart.rows);
            const std::size_t row = cell % std::size_t(chart.rows);
            if (first_u[column] == first_u[column + 1] || first_v[row] == first_v[row + 1])
                continue;
            const std::vector<PolynomialPiece> pieces = cell_pieces(source, chart.cells[cell]);
            const Eigen::Vector3d origin_u = Eigen::Vector3d::Constant(double(column));
            const Eigen::Vector3d origin_v = Eigen::Vector3d::Constant(double(row));
            for (std::size_t i = first_u[column]; i < first_u[column + 1]; ++i) {
                for (std::size_t j = first_v[row]; j < first_v[row + 1]; ++j) {
                    const auto piece =
                        std::find_if(pieces.begin(), pieces.end(), [&](const PolynomialPiece& p) {
                            return p.contains(u[i].middle - double(column),
                                              v[j].middle - double(row));
                        });
                    surface.point(Eigen::Index(i), Eigen::Index(j)) =
                        piece->blossom(u[i].arguments - origin_u, v[j].arguments - origin_v);
                }
            }
        }
    });
    return surface;
}

}  // namespace patchwright::patch
