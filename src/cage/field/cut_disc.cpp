#include "cage/field/cut_disc.h"

#include "cage/blocks/layout_refused.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Share of a triangle's side within which a vertex moves to a point on it, on the flat piece.
constexpr double near_vertex = 0.05;

}  // namespace

CutDisc::CutDisc(const FlatPiece& piece, int border)
    : points_(piece.points()), flat_(piece.flat()), on_wall_(points_.size(), 0) {
    std::fill_n(on_wall_.begin(), border, char(1));
    for (const auto& corners : piece.triangles()) {
        triangles_.emplace_back();
        set_triangle(int(triangles_.size()) - 1, corners);
    }
}

void CutDisc::set_triangle(int t, const std::array<int, 3>& corners) {
    triangles_[at(t)] = corners;
    for (std::size_t k = 0; k < 3; ++k) left_[{corners[k], corners[(k + 1) % 3]}] = t;
}

/// Puts another corner into a triangle.
void CutDisc::replace(int t, int from, int to) {
    auto corners = triangles_[at(t)];
    std::replace(corners.begin(), corners.end(), from, to);
    set_triangle(t, corners);
}

int CutDisc::split(int a, int b, double t, const Vec3& point) {
    const int m = int(points_.size());
    points_.push_back(point);
    flat_.emplace_back(flat_[at(a)] + t * (flat_[at(b)] - flat_[at(a)]));
    on_wall_.push_back(!has_side(a, b) || !has_side(b, a) ? 1 : 0);
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
        const auto found = left_.find({from, to});
        if (found == left_.end()) continue;
        const int triangle = found->second;
        left_.erase(found);
        auto other = triangles_[at(triangle)];
        replace(triangle, from, m);
        std::replace(other.begin(), other.end(), to, m);
        triangles_.emplace_back();
        set_triangle(int(triangles_.size()) - 1, other);
    }
    return m;
}

int CutDisc::add_vertex(const Vec2& p) {
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const auto c = triangles_[t];
        const Vec2 &a = flat(c[0]), &b = flat(c[1]), &d = flat(c[2]);
        const double area = cross(b - a, d - a);
        if (!(area > 0.0)) continue;
        const std::array<double, 3> w{cross(b - p, d - p) / area, cross(d - p, a - p) / area,
                                      cross(a - p, b - p) / area};
        const auto least = std::min_element(w.begin(), w.end()) - w.begin();
        if (w[at(least)] < 0.0) continue;
        for (std::size_t k = 0; k < 3; ++k)
            if (w[k] > 1.0 - near_vertex && move(c[k], p)) return c[k];
        const int from = c[at((least + 1) % 3)], to = c[at((least + 2) % 3)];
        if (w[at(least)] < near_vertex && has_side(to, from)) {
            const double share = w[at((least + 2) % 3)] / (1.0 - w[at(least)]);
            const int m = split(from, to, share, point(from) + share * (point(to) - point(from)));
            flat_[at(m)] = p;
            return m;
        }
        const int m = int(points_.size());
        points_.emplace_back(w[0] * point(c[0]) + w[1] * point(c[1]) + w[2] * point(c[2]));
        flat_.push_back(p);
        on_wall_.push_back(0);
        triangles_.resize(triangles_.size() + 2);
        set_triangle(int(t), {c[0], c[1], m});
        set_triangle(int(triangles_.size()) - 2, {c[1], c[2], m});
        set_triangle(int(triangles_.size()) - 1, {c[2], c[0], m});
        return m;
    }
    throw LayoutRefused{"a node is outside its piece"};
}

/// Moves a vertex on the flat piece; false, and it stays, where it is on a wall or triangles would
/// fold.
bool CutDisc::move(int v, const Vec2& p) {
    if (on_wall(v)) return false;
    for (auto it = left_.lower_bound({v, 0}); it != left_.lower_bound({v + 1, 0}); ++it) {
        const int a = it->first.second;
        const auto& c = triangles_[at(it->second)];
        const int b = c[at((std::find(c.begin(), c.end(), a) - c.begin() + 1) % 3)];
        if (!(cross(flat(a) - p, flat(b) - p) > 0.0)) return false;
    }
    flat_[at(v)] = p;
    return true;
}

/// The next vertex on a straight line, put there if need be.
int CutDisc::step_towards(int v, int to) {
    const Vec2 way = flat(to) - flat(v);
    for (auto [it, end] = std::pair(left_.lower_bound({v, 0}), left_.lower_bound({v + 1, 0}));
         it != end; ++it) {
        const int a = it->first.second;
        const auto& c = triangles_[at(it->second)];
        const int b = c[at((std::find(c.begin(), c.end(), a) - c.begin() + 1) % 3)];
        if (a == to || b == to) return to;
        const double before = cross(flat(a) - flat(v), way), after = cross(way, flat(b) - flat(v));
        if (before < 0.0 || after < 0.0 || !(before + after > 0.0)) continue;
        const double share = before / (before + after);
        const Vec2 where = flat(a) + share * (flat(b) - flat(a));
        if (share < near_vertex && move(a, where)) return a;
        if (share > 1.0 - near_vertex && move(b, where)) return b;
        if (!has_side(b, a) || walls_.contains(std::minmax(a, b))) break;
        return split(a, b, share, point(a) + share * (point(b) - point(a)));
    }
    throw LayoutRefused{"a piece cannot be cut"};
}

std::vector<int> CutDisc::draw(int from, int to) {
    std::vector<int> path{from};
    while (path.back() != to) {
        const int next = step_towards(path.back(), to);
        if (path.size() > points_.size()) throw LayoutRefused{"a piece cannot be cut"};
        walls_.insert(std::minmax(path.back(), next));
        path.push_back(next);
    }
    for (const int v : path) on_wall_[at(v)] = 1;
    return path;
}

std::vector<int> CutDisc::triangles_within(const std::vector<int>& loop) const {
    std::set<std::pair<int, int>> border;
    for (std::size_t i = 0; i < loop.size(); ++i)
        border.insert({loop[i], loop[(i + 1) % loop.size()]});
    const auto first = left_.find({loop[0], loop[1]});
    if (first == left_.end()) throw LayoutRefused{"a piece is cut off"};
    std::vector<int> result{first->second};
    std::set<int> seen{first->second};
    for (std::size_t i = 0; i < result.size(); ++i) {
        const auto& c = triangles_[at(result[i])];
        for (std::size_t k = 0; k < 3; ++k) {
            const int a = c[k], b = c[(k + 1) % 3];
            const auto next = left_.find({b, a});
            if (border.contains({a, b}) || next == left_.end()) continue;
            if (seen.insert(next->second).second) result.push_back(next->second);
        }
    }
    return result;
}

FlatPiece CutDisc::piece(const std::vector<int>& loop, std::vector<Vec2> border) {
    std::set<std::pair<int, int>> bridges;
    const std::set<int> on_loop(loop.begin(), loop.end());
    std::set<std::pair<int, int>> sides;
    for (std::size_t i = 0; i < loop.size(); ++i)
        sides.insert(std::minmax(loop[i], loop[(i + 1) % loop.size()]));
    for (const int t : triangles_within(loop)) {
        const auto& c = triangles_[at(t)];
        for (std::size_t k = 0; k < 3; ++k) {
            const auto side = std::minmax(c[k], c[(k + 1) % 3]);
            if (on_loop.contains(side.first) && on_loop.contains(side.second) &&
                !sides.contains(side))
                bridges.insert(side);
        }
    }
    for (const auto& [a, b] : bridges) split(a, b, 0.5, 0.5 * (point(a) + point(b)));
    std::vector<Vec3> points;
    std::map<int, int> number;
    const auto number_of = [&](int v) {
        const auto [it, added] = number.emplace(v, int(points.size()));
        if (added) points.push_back(point(v));
        return it->second;
    };
    for (const int v : loop) number_of(v);
    if (points.size() != loop.size()) throw LayoutRefused{"a piece touches itself"};
    std::vector<std::array<int, 3>> triangles;
    for (const int t : triangles_within(loop)) {
        const auto& c = triangles_[at(t)];
        triangles.push_back({number_of(c[0]), number_of(c[1]), number_of(c[2])});
    }
    return {std::move(points), std::move(triangles), std::move(border)};
}

}  // namespace patchwright::cage
