#include "geom/mesh_features.h"

#include "geom/angle.h"
#include "geom/mesh_sides.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace patchwright::geom {

namespace {

/// Of the diagonal: sharp lines that end inside a smooth surface are no features below this.
constexpr double shortest_end_rel = 0.02;
/// Of a full turn, what the angles at a point must lack for it to be a tip without features.
constexpr double tip_rad = 0.8;

struct FeatureLine {
    int a, b;
    FeatureKind kind;
    double angle;
    std::array<int, 2> triangle{-1, -1}, side{-1, -1};
    int chain = -1;
};

class Finding {
  public:
    Finding(const TriangleMesh& mesh, double sharp_angle_rad)
        : mesh_(mesh), sharp_(sharp_angle_rad), diagonal_(bounding_box(mesh.points).diagonal()) {
        collect_lines();
    }

    MeshFeatures run() {
        do {
            index_ends();
            find_corners();
            chain_all();
        } while (drop_accidents());
        number_all();
        return std::move(result_);
    }

  private:
    [[nodiscard]] Vec3 point(int v) const { return mesh_.points.row(v); }

    void collect_lines() {
        result_.beyond.assign(mesh_.triangles.size(), {-1, -1, -1});
        const auto sides = sorted_sides(mesh_);
        for (std::size_t i = 0; i < sides.size(); ++i) {
            const MeshSide& s = sides[i];
            FeatureLine line{s.low,        s.high, FeatureKind::Free, 0.0, {s.triangle, -1},
                             {s.side, -1}, -1};
            if (i + 1 < sides.size() && sides[i + 1].low == s.low && sides[i + 1].high == s.high) {
                const MeshSide& other = sides[++i];
                line.triangle[1] = other.triangle;
                line.side[1] = other.side;
                result_.beyond[std::size_t(s.triangle)][std::size_t(s.side)] = other.triangle;
                result_.beyond[std::size_t(other.triangle)][std::size_t(other.side)] = s.triangle;
                line.kind = FeatureKind::Sharp;
                line.angle = angle_between(area_vector(mesh_, s.triangle),
                                           area_vector(mesh_, other.triangle));
                if (!(line.angle > sharp_)) continue;
            }
            lines_.push_back(line);
        }
    }

    void index_ends() {
        ends_.assign(std::size_t(mesh_.points.rows()), {});
        for (std::size_t i = 0; i < lines_.size(); ++i) {
            lines_[i].chain = -1;
            ends_[std::size_t(lines_[i].a)].push_back(int(i));
            ends_[std::size_t(lines_[i].b)].push_back(int(i));
        }
    }

    [[nodiscard]] int other_end(int line, int v) const {
        const FeatureLine& l = lines_[std::size_t(line)];
        return l.a == v ? l.b : l.a;
    }

    void find_corners() {
        result_.features.corners.clear();
        result_.corner_of.assign(std::size_t(mesh_.points.rows()), -1);
        const std::vector<char> tips = find_tips();
        for (int v = 0; v < int(ends_.size()); ++v) {
            const auto kind = corner_kind(v);
            if (!kind && tips[std::size_t(v)] == 0) continue;
            result_.corner_of[std::size_t(v)] = int(result_.features.corners.size());
            result_.features.corners.push_back({point(v), kind.value_or(CornerKind::Apex), {}});
        }
    }

    [[nodiscard]] std::vector<char> find_tips() const {
        std::vector<double> angle(ends_.size(), 0.0);
        for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
            for (int k = 0; k < 3; ++k) {
                const Vec3 p = corner_point(mesh_, int(t), k);
                angle[std::size_t(mesh_.triangles[t][std::size_t(k)])] += angle_between(
                    corner_point(mesh_, int(t), k + 1) - p, corner_point(mesh_, int(t), k + 2) - p);
            }
        }
        std::vector<char> tips(ends_.size(), 0);
        for (std::size_t v = 0; v < tips.size(); ++v)
            tips[v] = ends_[v].empty() && angle[v] < 2.0 * M_PI - tip_rad;
        return tips;
    }

    [[nodiscard]] std::optional<CornerKind> corner_kind(int v) const {
        const auto& lines = ends_[std::size_t(v)];
        if (lines.empty()) return std::nullopt;
        if (lines.size() == 1) return CornerKind::End;
        std::vector<Vec3> directions;
        for (const int line : lines)
            directions.push_back((point(other_end(line, v)) - point(v)).normalized());
        for (std::size_t i = 0; i < directions.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (angle_between(directions[i], directions[j]) < sharp_) return CornerKind::Cusp;
        const bool one_kind =
            lines_[std::size_t(lines[0])].kind == lines_[std::size_t(lines[1])].kind;
        if (lines.size() == 2 && one_kind && angle_between(directions[0], -directions[1]) <= sharp_)
            return std::nullopt;
        return CornerKind::Junction;
    }

    /// The line that goes on from `line` through v; -1: none.
    [[nodiscard]] int after(int line, int v) const {
        if (result_.corner_of[std::size_t(v)] >= 0) return -1;
        const auto& lines = ends_[std::size_t(v)];
        return lines[0] == line ? lines[1] : lines[0];
    }

    void chain_all() {
        result_.chains.clear();
        result_.features.curves.clear();
        // Those that start at corners first: what is left then is closed.
        for (const bool from_corners : {true, false}) {
            for (std::size_t i = 0; i < lines_.size(); ++i) {
                for (const int v : {lines_[i].a, lines_[i].b}) {
                    const bool corner = result_.corner_of[std::size_t(v)] >= 0;
                    if (lines_[i].chain < 0 && corner == from_corners) chain_from(int(i), v);
                }
            }
        }
    }

    void chain_from(int line, int v) {
        MeshChain chain{{v}, {0.0}};
        FeatureCurve curve;
        curve.kind = lines_[std::size_t(line)].kind;
        curve.start = point(v);
        curve.start_corner = result_.corner_of[std::size_t(v)];
        curve.least_angle_rad = std::numeric_limits<double>::infinity();
        while (line >= 0 && lines_[std::size_t(line)].chain < 0) {
            FeatureLine& l = lines_[std::size_t(line)];
            l.chain = int(result_.chains.size());
            curve.least_angle_rad = std::min(curve.least_angle_rad, l.angle);
            curve.greatest_angle_rad = std::max(curve.greatest_angle_rad, l.angle);
            const int next = other_end(line, v);
            curve.length += (point(next) - point(v)).norm();
            chain.points.push_back(next);
            chain.arc.push_back(curve.length);
            v = next;
            line = after(line, v);
        }
        curve.end = point(v);
        curve.end_corner = result_.corner_of[std::size_t(v)];
        curve.closed = v == chain.points.front();
        result_.chains.push_back(std::move(chain));
        result_.features.curves.push_back(curve);
    }

    bool drop_accidents() {
        const auto is_end = [&](int corner) {
            return corner >= 0 &&
                   result_.features.corners[std::size_t(corner)].kind == CornerKind::End;
        };
        const auto accident = [&](const FeatureLine& line) {
            const FeatureCurve& curve = result_.features.curves[std::size_t(line.chain)];
            return curve.length < shortest_end_rel * diagonal_ &&
                   (is_end(curve.start_corner) || is_end(curve.end_corner));
        };
        return std::erase_if(lines_, accident) > 0;
    }

    void number_all() {
        for (std::size_t i = 0; i < result_.features.curves.size(); ++i) {
            const FeatureCurve& curve = result_.features.curves[i];
            for (const int corner : {curve.start_corner, curve.end_corner})
                if (corner >= 0)
                    result_.features.corners[std::size_t(corner)].curves.push_back(int(i));
        }
        result_.curve_under.assign(mesh_.triangles.size(), {-1, -1, -1});
        for (const FeatureLine& line : lines_) {
            result_.sides.push_back({line.a, line.b, line.chain});
            for (std::size_t k = 0; k < 2; ++k)
                if (line.triangle[k] >= 0)
                    result_.curve_under[std::size_t(line.triangle[k])][std::size_t(line.side[k])] =
                        line.chain;
        }
    }

    const TriangleMesh& mesh_;
    double sharp_, diagonal_;
    std::vector<FeatureLine> lines_;
    std::vector<std::vector<int>> ends_;  ///< lines at each point
    MeshFeatures result_;
};

}  // namespace

MeshFeatures find_mesh_features(const TriangleMesh& mesh, double sharp_angle_rad) {
    return Finding(mesh, sharp_angle_rad).run();
}

}  // namespace patchwright::geom
