#include "cage/field/size_metric.h"

#include "cage/remesh/size_field.h"
#include "geom/angle.h"
#include "geom/polyline.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace patchwright::cage {

using base::at;
using Eigen::Matrix2d;
using geom::Vec3;

namespace {

// By how much a length may grow per length of way, and how much longer than wide quads may be:
// curvature is looked at in single places, and longer quads miss where it changes along them.
constexpr double growth = 0.6, most_stretched = 24.0;
// Of the tolerance: shortest edge. What bends within less is flat to the tolerance.
constexpr double shortest_tolerances = 4.0;
// Steps along each line through a block, and where lines are taken, as shares of its width.
constexpr int line_steps = 32;
constexpr std::array line_shares{0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9};
// Least weight of a side between two triangles, whose cotangents sum up to less where these are
// obtuse: with positive weights the map does not fold.
constexpr double least_weight = 0.02;
// Of angles whose cotangents are taken.
constexpr double sine_floor = 1e-3;
// Share by which the square of a length must shrink, else it is left: grading ends.
constexpr double negligible = 0.02;

/// Length of an edge where the surface bends by `bend` radians a millimetre.
double edge_length(double bend, double diagonal, const MetricSizes& sizes) {
    const double longest = sizes.largest_rel * diagonal;
    if (!(bend > 0.0)) return longest * sizes.scale;
    const double shortest = shortest_tolerances * sizes.tolerance_rel * diagonal / sizes.fineness;
    const double wanted =
        angle_of_edge(sizes.tolerance_rel, diagonal, bend) / (bend * sizes.fineness);
    return std::clamp(wanted, std::min(shortest, longest), longest) * sizes.scale;
}

using Key = std::tuple<double, double, double>;
Key key_of(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
using EdgeKey = std::pair<Key, Key>;
EdgeKey edge_key(const Vec3& a, const Vec3& b) { return std::minmax(key_of(a), key_of(b)); }

/// A triangle with its metric.
struct Cell {
    PieceTriangle place;
    Vec3 middle;
    Vec3 normal;                       ///< of the surface there
    Eigen::Matrix<double, 3, 2> axes;  ///< unit vectors at right angles to it
    Matrix2d metric;                   ///< along these
    std::vector<int> next;             ///< cells beside it, but across features
};

double largest(const Matrix2d& m) {
    return 0.5 * m.trace() + std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
}

/// Of any way from a cell: what leaves its tangent plane goes around a bend, where edges are short.
Eigen::Matrix3d in_space(const Cell& cell) {
    return cell.axes * cell.metric * cell.axes.transpose() +
           largest(cell.metric) * cell.normal * cell.normal.transpose();
}

class Builder {
  public:
    Builder(const QuadLayout& layout, const geom::ModelSurface& reference, const MetricSizes& sizes,
            Poll& poll)
        : layout_(layout), reference_(reference), sizes_(sizes), poll_(poll) {
        add_cells();
        join();
        grade();
    }

    [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }

  private:
    void add_cells() {
        for (std::size_t p = 0; p < layout_.pieces.size(); ++p) {
            const FlatPiece& piece = layout_.pieces[p];
            for (std::size_t t = 0; t < piece.triangles().size(); ++t) {
                poll_();
                const auto& c = piece.triangles()[t];
                const Vec3 &a = piece.points()[at(c[0])], &b = piece.points()[at(c[1])],
                           &d = piece.points()[at(c[2])];
                const Vec3 normal = (b - a).cross(d - a).normalized();
                Cell cell{{int(p), int(t)}, (a + b + d) / 3.0, normal, {}, Matrix2d::Zero(), {}};
                set_metric(cell);
                cells_.push_back(std::move(cell));
            }
        }
    }

    /// By the surface and not by the triangle: where it bends within a triangle's size, the
    /// directions of long edges would be off by so much that they became short.
    void set_metric(Cell& cell) const {
        const double diagonal = reference_.size();
        std::optional<geom::Curvature> bend;
        if (cell.normal.norm() > 0.5)
            bend = reference_.curvature(reference_.foot_point(cell.middle, cell.normal));
        else
            cell.normal = Vec3::UnitZ();  // of no area
        if (bend) {
            const Vec3 normal = bend->direction[0].cross(bend->direction[1]);
            cell.normal = std::copysign(1.0, normal.dot(cell.normal)) * normal;
            cell.axes << bend->direction[0], bend->direction[1];
        } else {
            cell.axes.col(0) = cell.normal.unitOrthogonal();
            cell.axes.col(1) = cell.normal.cross(cell.axes.col(0));
        }
        Eigen::Array2d length;
        for (int j = 0; j < 2; ++j)
            length[j] = edge_length(bend ? std::abs(bend->value[at(j)]) : 0.0, diagonal, sizes_);
        length = length.min(most_stretched * length.minCoeff());
        cell.metric = length.square().inverse().matrix().asDiagonal();
    }

    void join() {
        std::set<EdgeKey> walls;
        for (const LayoutArc& arc : layout_.arcs)
            if (arc.curve >= 0)
                for (std::size_t i = 0; i + 1 < arc.points.size(); ++i)
                    walls.insert(edge_key(arc.points[i], arc.points[i + 1]));
        std::map<EdgeKey, int> first;
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            const FlatPiece& piece = layout_.pieces[at(cells_[i].place.piece)];
            const auto& c = piece.triangles()[at(cells_[i].place.triangle)];
            for (std::size_t k = 0; k < 3; ++k) {
                const EdgeKey key =
                    edge_key(piece.points()[at(c[k])], piece.points()[at(c[(k + 1) % 3])]);
                if (walls.contains(key)) continue;
                const auto [it, added] = first.emplace(key, int(i));
                if (added) continue;
                cells_[i].next.push_back(it->second);
                cells_[at(it->second)].next.push_back(int(i));
            }
        }
    }

    /// Raises `to` to the metric of `from`, grown along the way between them; true where it rose.
    static bool raise(const Cell& from, Cell& to) {
        const Vec3 way = to.middle - from.middle;
        const double length = std::sqrt(way.dot(in_space(from) * way));
        const double shrink = 1.0 / (1.0 + growth * length);
        const auto rolled = Eigen::Quaterniond::FromTwoVectors(from.normal, to.normal);
        const Matrix2d turn = to.axes.transpose() * rolled.toRotationMatrix() * from.axes;
        const Matrix2d carried = shrink * shrink * turn * from.metric * turn.transpose();
        // In the frame in which the own metric is the unit matrix.
        const Eigen::LLT<Matrix2d> own(to.metric);
        const Matrix2d root = own.matrixL();
        const Matrix2d inverse = root.inverse();
        const Matrix2d relative = inverse * carried * inverse.transpose();
        if (!(largest(relative) > 1.0 + negligible)) return false;
        Eigen::SelfAdjointEigenSolver<Matrix2d> eigen(relative);
        const Matrix2d raised = eigen.eigenvectors() *
                                eigen.eigenvalues().cwiseMax(1.0).asDiagonal() *
                                eigen.eigenvectors().transpose();
        // An ellipse within two others may be narrower than both.
        const double most = std::max(largest(to.metric), largest(carried));
        eigen.compute(root * raised * root.transpose());
        to.metric = eigen.eigenvectors() * eigen.eigenvalues().cwiseMin(most).asDiagonal() *
                    eigen.eigenvectors().transpose();
        return true;
    }

    void grade() {
        std::deque<int> pending;
        std::vector<char> waits(cells_.size(), 1);
        for (std::size_t i = 0; i < cells_.size(); ++i) pending.push_back(int(i));
        while (!pending.empty()) {
            poll_();
            const int i = pending.front();
            pending.pop_front();
            waits[at(i)] = 0;
            for (const int j : cells_[at(i)].next) {
                if (!raise(cells_[at(i)], cells_[at(j)]) || waits[at(j)] != 0) continue;
                waits[at(j)] = 1;
                pending.push_back(j);
            }
        }
    }

    const QuadLayout& layout_;
    const geom::ModelSurface& reference_;
    const MetricSizes& sizes_;
    Poll& poll_;
    std::vector<Cell> cells_;
};

/// Edges that each part of an arc on a feature is to get by how it bends itself.
std::vector<double> edges_by_curve(const LayoutArc& arc, const geom::ModelSurface& reference,
                                   const MetricSizes& sizes) {
    constexpr int parts = 4;
    const double diagonal = reference.size();
    std::vector<double> edges(arc.points.size() - 1, 0.0);
    for (std::size_t i = 0; i < edges.size() && arc.curve >= 0; ++i) {
        const Vec3 way = arc.points[i + 1] - arc.points[i];
        const double step = way.norm() / parts;
        if (!(step > 0.0)) continue;
        Vec3 before = reference.nearest_on_curve(arc.curve, arc.points[i]).tangent;
        for (int k = 1; k <= parts; ++k) {
            const Vec3 tangent =
                reference.nearest_on_curve(arc.curve, arc.points[i] + (double(k) / parts) * way)
                    .tangent;
            edges[i] +=
                step / edge_length(geom::angle_between(before, tangent) / step, diagonal, sizes);
            before = tangent;
        }
    }
    return edges;
}

/// What a whole side is to get goes to its arcs by what they are to get by themselves.
void raise(QuadLayout& layout, const BlockSide& side, double edges) {
    double whole = 0.0;
    for (const ArcUse& use : side) whole += layout.arcs[at(use.arc)].wanted;
    if (whole >= edges) return;
    for (const ArcUse& use : side) layout.arcs[at(use.arc)].wanted *= edges / whole;
}

/// Edges between two places of a flat piece.
double edges_between(const QuadLayout& layout, const SizeMetric& metric, int piece,
                     const Vec2& from, const Vec2& to) {
    double sum = 0.0;
    FlatPiece::SurfacePoint last = layout.pieces[at(piece)].at(from);
    for (int k = 1; k <= line_steps; ++k) {
        const auto here =
            layout.pieces[at(piece)].at(from + (to - from) * (double(k) / line_steps));
        sum += metric.length({piece, here.triangle}, here.point - last.point);
        last = here;
    }
    return sum;
}

/// The median of the lines through a block from side 3 to side 1, or from 0 to 2: some of them may
/// wander on the surface.
double edges_through(const QuadLayout& layout, const SizeMetric& metric, const LayoutBlock& block,
                     bool turned) {
    const auto corner = [&](int k) { return block.flat[at((k + (turned ? 1 : 0)) % 4)].front(); };
    std::array<double, line_shares.size()> edges;
    for (std::size_t i = 0; i < edges.size(); ++i)
        edges[i] = edges_between(layout, metric, block.piece,
                                 corner(0) + line_shares[i] * (corner(3) - corner(0)),
                                 corner(1) + line_shares[i] * (corner(2) - corner(1)));
    std::sort(edges.begin(), edges.end());
    return edges[edges.size() / 2];
}

using TrianglesBeside = std::map<EdgeKey, std::vector<PieceTriangle>>;

TrianglesBeside triangles_beside(const QuadLayout& layout) {
    TrianglesBeside beside;
    for (std::size_t p = 0; p < layout.pieces.size(); ++p) {
        const auto& points = layout.pieces[p].points();
        const auto& triangles = layout.pieces[p].triangles();
        for (std::size_t t = 0; t < triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
                beside[edge_key(points[at(triangles[t][k])], points[at(triangles[t][(k + 1) % 3])])]
                    .push_back({int(p), int(t)});
    }
    return beside;
}

}  // namespace

SizeMetric::SizeMetric(const QuadLayout& layout, const geom::ModelSurface& reference,
                       const MetricSizes& sizes, Poll& poll) {
    const Builder builder(layout, reference, sizes, poll);
    metric_.resize(layout.pieces.size());
    for (const Cell& cell : builder.cells())
        metric_[at(cell.place.piece)].push_back(in_space(cell));
}

double SizeMetric::product(const PieceTriangle& t, const Vec3& a, const Vec3& b) const {
    return a.dot(metric_[at(t.piece)][at(t.triangle)] * b);
}

double SizeMetric::length(const PieceTriangle& t, const Vec3& way) const {
    return std::sqrt(std::max(0.0, product(t, way, way)));
}

std::map<std::pair<int, int>, double> SizeMetric::side_weights(const FlatPiece& piece,
                                                               int number) const {
    std::map<std::pair<int, int>, double> weights;
    for (std::size_t t = 0; t < piece.triangles().size(); ++t) {
        const auto& corners = piece.triangles()[t];
        const PieceTriangle place{number, int(t)};
        for (std::size_t k = 0; k < 3; ++k) {
            const int i = corners[(k + 1) % 3], j = corners[(k + 2) % 3];
            const Vec3 to_i = piece.points()[at(i)] - piece.points()[at(corners[k])],
                       to_j = piece.points()[at(j)] - piece.points()[at(corners[k])];
            const double cosine = product(place, to_i, to_j);
            const double both = length(place, to_i) * length(place, to_j);
            const double sine = std::sqrt(std::max(0.0, both * both - cosine * cosine));
            weights[std::minmax(i, j)] += 0.5 * cosine / std::max(sine, sine_floor * both);
        }
    }
    for (auto& [side, weight] : weights) weight = std::max(weight, least_weight);
    return weights;
}

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
        LayoutArc& longer = geom::length_of(arc.points) < geom::length_of(first->points)
                                ? *std::exchange(first, &arc)
                                : arc;
        longer.least = 2;  // quads on both sides would share two edges
    }
}

void set_wanted(QuadLayout& layout, const SizeMetric& metric, const geom::ModelSurface& reference,
                const MetricSizes& sizes, Poll& poll) {
    constexpr double least_edges = 1e-9;  // keeps shares apart
    for (LayoutArc& arc : layout.arcs) arc.least = 0;
    set_least(layout);
    const TrianglesBeside beside = triangles_beside(layout);
    for (LayoutArc& arc : layout.arcs) {
        poll();
        const std::vector<double> by_curve = edges_by_curve(arc, reference, sizes);
        arc.shares = {0.0};
        for (std::size_t i = 0; i < by_curve.size(); ++i) {
            double edges = std::max(by_curve[i], least_edges);
            const auto found = beside.find(edge_key(arc.points[i], arc.points[i + 1]));
            if (found != beside.end())
                for (const PieceTriangle& t : found->second)
                    edges = std::max(edges, metric.length(t, arc.points[i + 1] - arc.points[i]));
            arc.shares.push_back(arc.shares.back() + edges);
        }
        arc.wanted = arc.shares.back();
        for (double& share : arc.shares) share /= arc.wanted;
    }
    for (const LayoutBlock& block : layout.blocks) {
        for (const bool turned : {false, true}) {
            poll();
            const double edges = edges_through(layout, metric, block, turned);
            raise(layout, block.sides[turned ? 1 : 0], edges);
            raise(layout, block.sides[turned ? 3 : 2], edges);
        }
    }
}

}  // namespace patchwright::cage
