#include "cage/blocks/shape_quads.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

class Shaper {
  public:
    Shaper(const QuadsOnModel& quads, std::vector<Vec3>& points,
           const geom::ModelSurface& reference, Poll& poll)
        : faces_(quads.faces),
          points_(points),
          freedom_(quads.freedom),
          normals_(quads.normals),
          reference_(reference),
          poll_(poll) {
        around_.resize(points.size());
        for (std::size_t f = 0; f < faces_.size(); ++f)
            for (const int v : faces_[f]) around_[at(v)].push_back(f);
        join(quads.creases);
    }

    void run() {
        for (int round = 0; round < rounds; ++round) {
            find_normals();
            find_ups();
            find_lengths();
            if (round > 0 && turned_over() > most_turned * double(faces_.size())) return;
            std::vector<char> awake(points_.size(), 1);
            bool rests = false;
            for (int sweep = 0; sweep < sweeps && !rests; ++sweep) {
                set_epsilon();
                rests = true;
                for (std::size_t v = 0; v < points_.size(); ++v) {
                    if (awake[v] == 0) continue;
                    awake[v] = 0;
                    if (improve(int(v)) < resting) continue;
                    rests = false;
                    for (const std::size_t f : around_[v])
                        for (const int w : faces_[f]) awake[at(w)] = 1;
                }
                if (sweep == 0 && round > 0 && rests) return;
            }
        }
    }

  private:
    // Times that lengths that edges should have and normals of quads are found anew, and sweeps
    // over all points in each.
    static constexpr int rounds = 12, sweeps = 8;
    // Times that lengths are averaged with those of the quads beside them.
    static constexpr int averagings = 4;
    // Share of the least negative area, and share of an area, by which areas are kept from zero.
    static constexpr double fold_share = 0.2, least_area = 1e-3;
    // Halvings of a step that does not lower the energy, and its largest length as a share of the
    // shortest edge around a point.
    static constexpr int step_halvings = 4;
    static constexpr double longest_step = 0.5;
    // Sine of the angles of quads (24 degrees) from which on points on features stay where sizes
    // along the features put them, and those on lines.
    static constexpr double well_formed = 0.4;
    // Share of quads that are turned over after a round from which on more rounds do not help.
    static constexpr double most_turned = 0.1;
    // Largest step, as a share of the edges around a point, at which points rest.
    static constexpr double resting = 1e-3;
    // Cosine between normals before and after a step below which they are not those of one
    // side of a part.
    static constexpr double agrees = 0.5;
    // Of a step, how far the point on the model may come to lie: where it is farther it is on
    // another part.
    static constexpr double farthest_foot = 1.5;

    void join(const std::vector<std::pair<int, int>>& creases) {
        std::set<std::pair<int, int>> is_crease;
        for (const auto& [a, b] : creases) is_crease.insert(std::minmax(a, b));
        std::map<std::pair<int, int>, std::pair<int, int>> side_of;
        for (std::size_t f = 0; f < faces_.size(); ++f)
            for (int k = 0; k < 4; ++k)
                side_of[{faces_[f][at(k)], faces_[f][at((k + 1) % 4)]}] = {int(f), k};
        beyond_.assign(faces_.size(), {});
        crease_.assign(faces_.size(), {});
        for (std::size_t f = 0; f < faces_.size(); ++f)
            for (int k = 0; k < 4; ++k) {
                const int from = faces_[f][at(k)], to = faces_[f][at((k + 1) % 4)];
                const auto other = side_of.find({to, from});
                crease_[f][at(k)] = is_crease.count(std::minmax(from, to)) > 0;
                beyond_[f][at(k)] = other != side_of.end() ? other->second : std::pair{-1, -1};
            }
    }

    [[nodiscard]] const Vec3& corner(std::size_t f, int k) const {
        return points_[at(faces_[f][at(k % 4)])];
    }

    /// Those of the model near the quads, on the side where they were: thin parts have another one.
    void find_normals() {
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            poll_();
            const Vec3 middle = 0.25 * (corner(f, 0) + corner(f, 1) + corner(f, 2) + corner(f, 3));
            const Vec3 normal = reference_.foot_point(middle, normals_[f]).normal;
            if (normal.dot(normals_[f]) > agrees) normals_[f] = normal;
        }
    }

    /// Normals of the model at points that move on it, on the side that the quads around them are.
    void find_ups() {
        up_.assign(points_.size(), Vec3::Zero());
        for (std::size_t v = 0; v < points_.size(); ++v) {
            if (!freedom_[v].on_surface()) continue;
            poll_();
            Vec3 sum = Vec3::Zero();
            for (const std::size_t f : around_[v]) sum += normals_[f];
            if (sum.norm() > 0.0)
                up_[v] = reference_.foot_point(points_[v], sum.normalized()).normal;
        }
    }

    [[nodiscard]] double own_length(std::size_t f, int d) const {
        return 0.5 * ((corner(f, d + 1) - corner(f, d)).norm() +
                      (corner(f, d + 3) - corner(f, d + 2)).norm());
    }

    /// Lengths of a quad's edges and of those around it, averaged: a quad alone that has become
    /// small does not stay so.
    void find_lengths() {
        lengths_.assign(faces_.size(), {});
        for (std::size_t f = 0; f < faces_.size(); ++f)
            for (int d = 0; d < 2; ++d) lengths_[f][at(d)] = own_length(f, d);
        for (int step = 0; step < averagings; ++step) {
            const auto before = lengths_;
            for (std::size_t f = 0; f < faces_.size(); ++f)
                for (int d = 0; d < 2; ++d) {
                    double sum = before[f][at(d)], count = 1.0;
                    for (int side = 0; side < 4; ++side) {
                        const auto& [g, k] = beyond_[f][at(side)];
                        if (g < 0) continue;
                        if (side % 2 != d && crease_[f][at(side)]) continue;
                        // Edges of g that are parallel to side k, or not, as d and side here.
                        sum += before[at(g)][at((k + (side % 2 == d ? 0 : 1)) % 2)];
                        count += 1.0;
                    }
                    lengths_[f][at(d)] = sum / count;
                }
        }
    }

    /// Area at a corner of a quad in units of what it should be.
    [[nodiscard]] double area(std::size_t f, int k) const {
        const Vec3 a = corner(f, k + 1) - corner(f, k), b = corner(f, k + 3) - corner(f, k);
        return a.cross(b).dot(normals_[f]) / (lengths_[f][0] * lengths_[f][1]);
    }

    /// Quads one of whose corners is turned over.
    [[nodiscard]] int turned_over() const {
        int count = 0;
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            bool is = false;
            for (int k = 0; k < 4; ++k) is = is || area(f, k) < 0.0;
            count += is ? 1 : 0;
        }
        return count;
    }

    void set_epsilon() {
        double least = 0.0;
        for (std::size_t f = 0; f < faces_.size(); ++f)
            for (int k = 0; k < 4; ++k) least = std::min(least, area(f, k));
        epsilon_ = std::hypot(least_area, fold_share * least);
    }

    /// Energy around a point that is moved by x in a frame, with its derivatives by x.
    struct Local {
        double value = 0.0;
        Eigen::Vector2d slope = Eigen::Vector2d::Zero();
        Eigen::Matrix2d bend = Eigen::Matrix2d::Zero();
    };
    using Frame = Eigen::Matrix<double, 3, 2>;

    /// A corner of a quad, as seen along the quad's normal.
    struct Corner {
        Vec3 a, b;                         ///< sides to the next and to the previous corner
        double la, lb;                     ///< lengths that they should have
        double stretch;                    ///< half the mean square of what they have of these
        double area, root, positive_area;  ///< of what it should be; the last one is above 0

        [[nodiscard]] double energy() const { return stretch / positive_area; }
    };

    [[nodiscard]] Corner corner_of(std::size_t f, int k) const {
        const Vec3& n = normals_[f];
        Vec3 a = corner(f, k + 1) - corner(f, k), b = corner(f, k + 3) - corner(f, k);
        a -= a.dot(n) * n;
        b -= b.dot(n) * n;
        const double la = lengths_[f][at(k % 2)], lb = lengths_[f][at((k + 1) % 2)];
        const double stretch = 0.5 * (a.squaredNorm() / (la * la) + b.squaredNorm() / (lb * lb));
        const double area = a.cross(b).dot(n) / (la * lb), root = std::hypot(epsilon_, area);
        return {a, b, la, lb, stretch, area, root, 0.5 * (area + root)};
    }

    /// How the sides of a corner of a quad move with a point: 1, -1 or 0 times as it does.
    [[nodiscard]] std::array<double, 2> side_motions(std::size_t f, int k, int v) const {
        const auto of = [&](int other) {
            return faces_[f][at(k)] == v ? -1.0 : faces_[f][at((k + other) % 4)] == v ? 1.0 : 0.0;
        };
        return {of(1), of(3)};
    }

    void add(Local& sum, std::size_t f, int k, int v, const Frame& frame) const {
        const auto [ga, gb] = side_motions(f, k, v);
        if (ga == 0.0 && gb == 0.0) return;
        const Vec3& n = normals_[f];
        const Corner here = corner_of(f, k);
        const double la = here.la, lb = here.lb;
        const Frame t = frame - n * (n.transpose() * frame);
        const Eigen::Vector2d g =
            t.transpose() * (ga / (la * la) * here.a + gb / (lb * lb) * here.b);
        const Eigen::Matrix2d h = (ga * ga / (la * la) + gb * gb / (lb * lb)) * t.transpose() * t;
        const Eigen::Vector2d c =
            t.transpose() * (ga * here.b.cross(n) + gb * n.cross(here.a)) / (la * lb);
        const double x = here.positive_area, q = 0.5 * (1.0 + here.area / here.root) / x;
        sum.value += here.energy();
        sum.slope += g / x - here.energy() * q * c;
        sum.bend += h / x - (g * c.transpose() + c * g.transpose()) * (q / x) +
                    2.0 * here.energy() * q * q * c * c.transpose();
    }

    [[nodiscard]] Local around(int v, const Frame& frame) const {
        Local sum;
        for (const std::size_t f : around_[at(v)])
            for (int k = 0; k < 4; ++k) add(sum, f, k, v, frame);
        return sum;
    }
    /// The value alone.
    [[nodiscard]] double energy_around(int v) const {
        double sum = 0.0;
        for (const std::size_t f : around_[at(v)])
            for (int k = 0; k < 4; ++k)
                if (side_motions(f, k, v) != std::array{0.0, 0.0}) sum += corner_of(f, k).energy();
        return sum;
    }

    [[nodiscard]] double reach(int v) const {
        double least = base::infinity;
        for (const std::size_t f : around_[at(v)])
            for (int k = 0; k < 4; ++k)
                if (faces_[f][at(k)] == v || faces_[f][at((k + 1) % 4)] == v)
                    least = std::min(least, lengths_[f][at(k % 2)]);
        return least;
    }

    /// Whether no quad around a point has a small angle or one near 180 degrees.
    [[nodiscard]] bool is_well_formed(int v) const {
        for (const std::size_t f : around_[at(v)])
            for (int k = 0; k < 4; ++k)
                if (corner_sine(points_, faces_[f], k, normals_[f]) < well_formed) return false;
        return true;
    }

    /// Directions that a point may go in; the second is zero along features and lines.
    [[nodiscard]] Frame frame_at(int v) const {
        const Freedom& freedom = freedom_[at(v)];
        const Vec3 normal = up_[at(v)];
        Frame frame = Frame::Zero();
        if (freedom.free) {
            frame.col(0) = normal.unitOrthogonal();
            frame.col(1) = normal.cross(frame.col(0));
        } else if (freedom.on_line()) {
            frame.col(0) = (freedom.line - freedom.line.dot(normal) * normal).normalized();
        } else {
            frame.col(0) = reference_.nearest_on_curve(freedom.curve, points_[at(v)]).tangent;
        }
        return frame;
    }

    /// @return how far the point went, as a share of the edges around it
    double improve(int v) {
        const Freedom& freedom = freedom_[at(v)];
        if (!freedom.moves() || (!freedom.free && is_well_formed(v))) return 0.0;
        const Vec3 normal = up_[at(v)];
        if (freedom.on_surface() && !(normal.norm() > 0.5)) return 0.0;
        poll_();
        const Vec3 old = points_[at(v)];
        const Frame frame = frame_at(v);
        const Local now = around(v, frame);
        Eigen::Vector2d step = Eigen::Vector2d::Zero();
        if (freedom.free)
            step = -now.bend.ldlt().solve(now.slope);
        else if (now.bend(0, 0) > 0.0)
            step.x() = -now.slope.x() / now.bend(0, 0);
        if (!step.allFinite() || !(step.norm() > 0.0)) return 0.0;
        const double most = longest_step * reach(v);
        if (step.norm() > most) step *= most / step.norm();
        if (step.norm() < resting * most) return 0.0;
        for (int halving = 0; halving < step_halvings; ++halving, step *= 0.5) {
            const Vec3 there = old + frame * step;
            points_[at(v)] = there;
            if (energy_around(v) >= now.value) continue;
            if (freedom.on_surface()) {
                const geom::FootPoint foot = reference_.foot_point(there, normal);
                if (foot.normal.dot(normal) < agrees ||
                    (foot.point - old).norm() > farthest_foot * step.norm())
                    continue;
                points_[at(v)] = foot.point;
                up_[at(v)] = foot.normal;
            } else {
                points_[at(v)] = reference_.nearest_on_curve(freedom.curve, there).point;
            }
            if (energy_around(v) < now.value) return step.norm() / most;
        }
        points_[at(v)] = old;
        up_[at(v)] = normal;
        return 0.0;
    }

    const std::vector<std::vector<int>>& faces_;
    std::vector<Vec3>& points_;
    const std::vector<Freedom>& freedom_;
    std::vector<Vec3> normals_;  ///< of the model where the quads are
    const geom::ModelSurface& reference_;
    Poll& poll_;
    std::vector<std::vector<std::size_t>> around_;
    std::vector<std::array<std::pair<int, int>, 4>> beyond_;  ///< face and its side, or -1
    std::vector<std::array<bool, 4>> crease_;                 ///< of each side
    std::vector<std::array<double, 2>> lengths_;  ///< that edges 0 and 2, 1 and 3 should have, mm
    std::vector<Vec3> up_;                        ///< normals of the model at free points
    double epsilon_ = 0.0;
};

}  // namespace

void shape_quads(const QuadsOnModel& quads, std::vector<Vec3>& points,
                 const geom::ModelSurface& reference, Poll& poll) {
    Shaper(quads, points, reference, poll).run();
}

}  // namespace patchwright::cage
