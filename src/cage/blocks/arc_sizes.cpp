#include "cage/blocks/arc_sizes.h"

#include "cage/remesh/size_field.h"
#include "geom/angle.h"
#include "geom/polyline.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Where lines through a block are taken, as shares of its width.
constexpr std::array line_shares{0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9};
// Steps along each of them.
constexpr int line_steps = 32;
// Fewest edges of an arc that ends where it starts, and of several between the same two nodes but
// for the shortest of these: quads on both sides would share two edges.
constexpr int fewest_of_loop = 4, fewest_of_parallel = 2;

double length_of(const LayoutArc& arc) {
    return arc.points.empty() ? 0.0 : geom::arc_lengths(arc.points).back();
}

/// Edges a millimetre where a line bends by `bend` radians a millimetre.
double density(double bend, double diagonal, const ArcSizes& sizes) {
    const double longest = sizes.largest_rel * diagonal;
    if (!(bend > 0.0)) return 1.0 / longest;
    return std::max(1.0 / longest,
                    bend / angle_of_edge(sizes.tolerance_rel, diagonal, bend) * sizes.fineness);
}

/// Edges that a line is to get that bends evenly.
double edges_along(const std::vector<Vec3>& points, double diagonal, const ArcSizes& sizes) {
    double length = 0.0, turn = 0.0;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Vec3 way = points[i + 1] - points[i];
        length += way.norm();
        if (i > 0) turn += geom::angle_between(points[i] - points[i - 1], way);
    }
    if (!(length > 0.0)) return 0.0;
    return length * density(turn / length, diagonal, sizes) / sizes.scale;
}

/// Edges that a line is to get when all are as short as the places want on average that it bends
/// at: the root of the mean square.
double even_edges_along(const std::vector<Vec3>& points, double diagonal, const ArcSizes& sizes) {
    double length = 0.0, sum = 0.0;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        const Vec3 before = points[i] - points[i - 1], way = points[i + 1] - points[i];
        const double step = 0.5 * (before.norm() + way.norm());
        if (!(step > 0.0)) continue;
        length += step;
        sum +=
            step * std::pow(density(geom::angle_between(before, way) / step, diagonal, sizes), 2.0);
    }
    return length > 0.0 ? std::sqrt(length * sum) / sizes.scale : 0.0;
}

/// Points of the line at a share of the way from side 0 of a block to side 2, and of the one from
/// side 3 to side 1 with `turned`.
std::vector<Vec3> line_through(const QuadLayout& layout, const LayoutBlock& block, double share,
                               bool turned) {
    const auto corner = [&](int k) { return block.flat[at((k + (turned ? 1 : 0)) % 4)].front(); };
    const Vec2 from = corner(0) + share * (corner(3) - corner(0)),
               to = corner(1) + share * (corner(2) - corner(1));
    std::vector<Vec3> line;
    for (int k = 0; k <= line_steps; ++k)
        line.push_back(
            layout.pieces[at(block.piece)].at(from + (to - from) * (double(k) / line_steps)).point);
    return line;
}

/// What a whole side is to get goes to its arcs by their lengths on the flat piece.
void raise(QuadLayout& layout, const LayoutBlock& block, int side, double edges) {
    const auto& flat = block.flat[at(side)];
    const Vec2 end = block.flat[at((side + 1) % 4)].front();
    const double whole = (end - flat.front()).norm();
    for (std::size_t i = 0; i < flat.size(); ++i) {
        const Vec2 next = i + 1 < flat.size() ? flat[i + 1] : end;
        double& wanted = layout.arcs[at(block.sides[at(side)][i].arc)].wanted;
        wanted = std::max(wanted, edges * (next - flat[i]).norm() / std::max(whole, 1e-300));
    }
}

}  // namespace

void set_least(QuadLayout& layout) {
    std::map<std::pair<int, int>, LayoutArc*> shortest;
    for (LayoutArc& arc : layout.arcs) {
        if (arc.start == arc.end) {
            arc.least = fewest_of_loop;
            continue;
        }
        LayoutArc*& first = shortest[std::minmax(arc.start, arc.end)];
        if (first == nullptr) {
            first = &arc;
            continue;
        }
        LayoutArc& longer = length_of(arc) < length_of(*first) ? *std::exchange(first, &arc) : arc;
        longer.least = fewest_of_parallel;
    }
}

void set_wanted(QuadLayout& layout, const geom::ModelSurface& reference, const ArcSizes& sizes,
                Poll& poll) {
    const double diagonal = reference.size();
    set_least(layout);
    for (LayoutArc& arc : layout.arcs) {
        arc.wanted = edges_along(arc.points, diagonal, sizes);
    }
    for (const LayoutBlock& block : layout.blocks) {
        for (const bool turned : {false, true}) {
            double edges = 0.0;
            for (const double share : line_shares) {
                poll();
                edges = std::max(edges, even_edges_along(line_through(layout, block, share, turned),
                                                         diagonal, sizes));
            }
            raise(layout, block, turned ? 1 : 0, edges);
            raise(layout, block, turned ? 3 : 2, edges);
        }
    }
}

}  // namespace patchwright::cage
