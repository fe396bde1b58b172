#include "measure/surface_pieces.h"

#include <patchwright/base/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::measure {

using geom::Vec3;

// Two points of a surface differ by a sum of derivatives along any way between them. Along one of
// which both parameters run one way only, they differ by a d + b e with a, b >= 0, d a mean of the
// derivatives along u and e of those along v (or with the other sign of v). So a piece does not
// meet itself, nor do two pieces that touch in the parameter plane meet elsewhere, where the
// derivatives of all of them fit into one half-space for each sign. This needs no condition on the
// boundary, unlike a bound on normals (Volino, Magnenat-Thalmann, Efficient self-collision
// detection on smoothly discretized surface animations, 1994).

namespace {

bool is_simple(const DirectionCone& du, const DirectionCone& dv) {
    return share_half_space({du, dv}) && share_half_space({du, dv.opposite()});
}

/// From where the surface's lines begin to where they end, in the mean; empty where they lead back.
std::optional<Vec3> mean_chord(const geom::BsplineSurface& s, bool along_u) {
    constexpr double least_share = 1e-4;  // of the lines' length
    Vec3 sum = Vec3::Zero();
    double length = 0.0;
    for (Eigen::Index i = along_u ? 1 : 0; i < s.rows(); ++i) {
        for (Eigen::Index j = along_u ? 0 : 1; j < s.columns(); ++j) {
            const Vec3 step =
                (s.point(i, j) - s.point(along_u ? i - 1 : i, along_u ? j : j - 1)).transpose();
            sum += step;
            length += step.norm();
        }
    }
    if (!(sum.norm() > least_share * length)) return std::nullopt;
    return Vec3(sum / double(along_u ? s.columns() : s.rows()));
}

/// In which the mean chords of both kinds of lines are at right angles and equally long: on a
/// slender surface both run along it wherever they are oblique, almost opposite to each other,
/// which takes pieces as small as it is narrow to tell.
SurfaceFrame frame_of(const geom::BsplineSurface& surface, double resolution) {
    constexpr double least_of_resolution = 1e-7, least_rel = 1e-12;
    // Rounding of directions grows as angles are widened, and as lengths are made equal.
    constexpr double least_sine = 1e-3, least_width = 1e-3;
    SurfaceFrame frame;
    frame.least_mm = std::max(least_of_resolution * resolution,
                              least_rel * geom::bounding_box(surface.points).diagonal());
    const auto u = mean_chord(surface, true), v = mean_chord(surface, false);
    if (!u || !v) return frame;
    const Vec3 normal = u->normalized().cross(v->normalized());
    const double sine = normal.norm();
    if (!(sine > least_sine)) return frame;
    const double longest = std::max(u->norm(), v->norm());
    const auto width = [&](const Vec3& chord) {
        return std::max(chord.norm() / longest, least_width);
    };
    Eigen::Matrix3d axes;
    axes << width(*u) * u->normalized(), width(*v) * v->normalized(), normal / sine;
    frame.map = axes.inverse();
    frame.least_mm /= sine * std::min(width(*u), width(*v));
    return frame;
}

}  // namespace

Domain::Domain(const geom::BsplineSurface& s)
    : u{s.knots_u.front(), s.knots_u.back()}, v{s.knots_v.front(), s.knots_v.back()} {
    // Shared sides come from the same numbers; files keep 15 digits of them.
    constexpr double same_rel = 1e-9;
    const double same = same_rel * geom::bounding_box(s.points).diagonal();
    const Eigen::Index last_u = s.rows() - 1, last_v = s.columns() - 1;
    closed_u = closed_v = true;
    is_point.fill(true);
    for (Eigen::Index j = 0; j <= last_v; ++j) {
        closed_u = closed_u && (s.point(0, j) - s.point(last_u, j)).norm() <= same;
        is_point[0] = is_point[0] && (s.point(0, j) - s.point(0, 0)).norm() <= same;
        is_point[1] = is_point[1] && (s.point(last_u, j) - s.point(last_u, 0)).norm() <= same;
    }
    for (Eigen::Index i = 0; i <= last_u; ++i) {
        closed_v = closed_v && (s.point(i, 0) - s.point(i, last_v)).norm() <= same;
        is_point[2] = is_point[2] && (s.point(i, 0) - s.point(0, 0)).norm() <= same;
        is_point[3] = is_point[3] && (s.point(i, last_v) - s.point(0, last_v)).norm() <= same;
    }
}

bool Domain::touch(const Extent& a, const Extent& b) const {
    const auto meet = [](const auto& r, const auto& q, const auto& whole, bool closed) {
        return (r[0] <= q[1] && q[0] <= r[1]) ||
               (closed &&
                ((r[0] == whole[0] && q[1] == whole[1]) || (q[0] == whole[0] && r[1] == whole[1])));
    };
    return meet(a.u, b.u, u, closed_u) && meet(a.v, b.v, v, closed_v);
}

SurfacePieces::SurfacePieces(const geom::BsplineSurface& surface, double resolution)
    : surface_(surface),
      resolution_(resolution),
      domain_(surface),
      frame_(frame_of(surface, resolution)) {
    BezierGrid grid = bezier_grid(surface, frame_);
    spans_v_ = grid.spans_v;
    pieces_ = std::move(grid.pieces);
    span_count_ = int(pieces_.size());
    halves_.assign(pieces_.size(), -1);
    nodes_.reserve(2 * pieces_.size());
    build(0, grid.spans_u, 0, grid.spans_v);
}

std::vector<SurfacePieces::Pair> SurfacePieces::candidates() const {
    std::vector<Pair> pairs;
    within(0, pairs);
    return pairs;
}

int SurfacePieces::build(std::size_t i0, std::size_t i1, std::size_t j0, std::size_t j1) {
    const int number = int(nodes_.size());
    nodes_.emplace_back();
    if (i1 - i0 == 1 && j1 - j0 == 1) {
        Node leaf{pieces_[i0 * spans_v_ + j0]};
        leaf.span = int(i0 * spans_v_ + j0);
        nodes_[std::size_t(number)] = leaf;
        return number;
    }
    std::array<int, 2> child{};
    if (i1 - i0 >= j1 - j0) {
        const std::size_t half = (i0 + i1) / 2;
        child = {build(i0, half, j0, j1), build(half, i1, j0, j1)};
    } else {
        const std::size_t half = (j0 + j1) / 2;
        child = {build(i0, i1, j0, half), build(i0, i1, half, j1)};
    }
    const Node &a = nodes_[std::size_t(child[0])], &b = nodes_[std::size_t(child[1])];
    Node node;
    node.child = child;
    node.u = {a.u[0], b.u[1]};
    node.v = {a.v[0], b.v[1]};
    node.box = a.box;
    node.box.add(b.box);
    node.framed = a.framed;
    node.framed.add(b.framed);
    node.du = merge(a.du, b.du);
    node.dv = merge(a.dv, b.dv);
    nodes_[std::size_t(number)] = node;
    return number;
}

void SurfacePieces::within(int number, std::vector<Pair>& pairs) const {
    const Node& node = nodes_[std::size_t(number)];
    if (is_simple(node.du, node.dv)) return;
    if (node.span >= 0) {
        pairs.push_back({node.span, node.span});
        return;
    }
    within(node.child[0], pairs);
    within(node.child[1], pairs);
    between(node.child[0], node.child[1], pairs);
}

void SurfacePieces::between(int first, int second, std::vector<Pair>& pairs) const {
    const Node &a = nodes_[std::size_t(first)], &b = nodes_[std::size_t(second)];
    if (relation(a, b) == Relation::Apart) return;
    if (a.span >= 0 && b.span >= 0) {
        pairs.push_back({a.span, b.span});
    } else if (b.span >= 0 || (a.span < 0 && a.size() >= b.size())) {
        for (const int child : a.child) between(child, second, pairs);
    } else {
        for (const int child : b.child) between(first, child, pairs);
    }
}

SurfacePieces::Relation SurfacePieces::relation(const Extent& a, const Extent& b) const {
    if ((a.framed.min.array() > b.framed.max.array()).any() ||
        (b.framed.min.array() > a.framed.max.array()).any())
        return Relation::Apart;
    if (domain_.touch(a, b)) {
        const bool simple = share_half_space({a.du, b.du, a.dv, b.dv}) &&
                            share_half_space({a.du, b.du, a.dv.opposite(), b.dv.opposite()});
        return simple ? Relation::Apart : Relation::Joined;
    }
    for (std::size_t side = 0; side < 4; ++side) {
        if (!domain_.is_point[side] || !domain_.on_side(a, side) || !domain_.on_side(b, side))
            continue;
        const auto& from = side < 2 ? a.du : a.dv;
        const auto& to = side < 2 ? b.du : b.dv;
        return share_half_space({from.opposite(), to}) ? Relation::Apart : Relation::Joined;
    }
    return Relation::Open;
}

SurfacePieces::Outcome SurfacePieces::test(const Pair& pair) const {
    const BezierPiece& a = pieces_[std::size_t(pair[0])];
    if (pair[0] != pair[1]) return test(a, pieces_[std::size_t(pair[1])]);
    const bool done =
        is_simple(a.du, a.dv) || a.size() <= resolution_ || run_one_way(a, a, frame_.least_mm);
    return {done ? Next::Nothing : Next::HalveFirst, {}};
}

SurfacePieces::Outcome SurfacePieces::test(const BezierPiece& a, const BezierPiece& b) const {
    const bool small = a.size() <= resolution_ && b.size() <= resolution_;
    if (small && domain_.touch(a, b)) return {};
    const Relation relation = this->relation(a, b);
    if (relation == Relation::Apart) return {};
    if (relation == Relation::Open) {
        if (are_apart(a, b, 0.0)) return {};
        if (const auto hit = loop_at(a, b)) return {Next::Nothing, hit};
    }
    if (small ||
        (relation == Relation::Joined && domain_.touch(a, b) && run_one_way(a, b, frame_.least_mm)))
        return {};
    return {a.size() >= b.size() ? Next::HalveFirst : Next::HalveSecond, {}};
}

std::optional<SelfIntersection> SurfacePieces::loop_at(const BezierPiece& a,
                                                       const BezierPiece& b) const {
    constexpr double exact = 1e-6;  // of the resolution
    const auto met = meeting_point(a, b, exact * resolution_);
    if (!met || !is_loop(*met)) return std::nullopt;
    return SelfIntersection{{}, met->point, met->uv};
}

/// Whether the surface leaves the place between the two visits, which are not merely at sides that
/// are joined.
bool SurfacePieces::is_loop(const PieceMeeting& hit) const {
    const auto beside = [&](const Eigen::Vector2d& uv) {
        return is_beside_side(surface_, hit.point, uv, resolution_);
    };
    return !stays_near(surface_, hit.point, hit.uv[0], hit.uv[1], resolution_) &&
           !(beside(hit.uv[0]) && beside(hit.uv[1]));
}

void SurfacePieces::halve(const std::vector<int>& pieces) {
    std::vector<int> wanted;
    int next = int(pieces_.size());
    for (const int piece : pieces) {
        int& half = halves_[std::size_t(piece)];
        if (half >= 0) continue;
        half = next;
        next += 2;
        wanted.push_back(piece);
    }
    pieces_.resize(std::size_t(next));
    halves_.resize(std::size_t(next), -1);
    constexpr std::size_t grain = 64;
    base::parallel_for(wanted.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const auto first = std::size_t(half(wanted[k]));
            auto halves = pieces_[std::size_t(wanted[k])].halves(frame_);
            pieces_[first] = halves[0];
            pieces_[first + 1] = halves[1];
        }
    });
}

}  // namespace patchwright::measure
