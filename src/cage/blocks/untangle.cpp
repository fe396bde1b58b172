#include "cage/blocks/untangle.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Sine of a quad's angle (9 degrees, or 171) below which its corners are moved.
constexpr double well_formed = 0.15;
// Sine (30 degrees) above which angles around a point need no improvement.
constexpr double good_enough_face = 0.5;
// Cosine between a quad and the surface below which the quad's own normal says more: it is bent.
constexpr double agrees = 0.5;
// Rounds over all points; in each a point is tried in so many directions, with steps of this share
// of the edges around it that are halved so often, and moved when the least sine grows by this.
constexpr int rounds = 12, directions = 8, step_halvings = 4;
constexpr double first_step = 0.4, least_gain = 1e-3;

class Untangler {
  public:
    Untangler(const std::vector<std::vector<int>>& faces, std::vector<Vec3>& points,
              const std::vector<Freedom>& freedom, const geom::ModelSurface& reference, Poll& poll)
        : faces_(faces), points_(points), freedom_(freedom), reference_(reference), poll_(poll) {
        around_.resize(points.size());
        changed_around_.assign(points.size(), true);
        for (std::size_t f = 0; f < faces.size(); ++f)
            for (const int v : faces[f]) around_[at(v)].push_back(f);
    }

    void run() {
        normals_.resize(faces_.size());
        for (std::size_t f = 0; f < faces_.size(); ++f) find_normal(f);
        for (int round = 0; round < rounds; ++round) {
            std::set<int> moving;
            for (std::size_t f = 0; f < faces_.size(); ++f) {
                if (least_sine(f) >= well_formed) continue;
                for (const int v : faces_[f])
                    for (const std::size_t g : around_[at(v)])
                        moving.insert(faces_[g].begin(), faces_[g].end());
            }
            std::set<std::size_t> moved;
            for (const int v : moving) {
                if (!changed_around_[at(v)]) continue;
                changed_around_[at(v)] = false;
                if (!improve(v)) continue;
                for (const std::size_t f : around_[at(v)]) {
                    moved.insert(f);
                    for (const int w : faces_[f]) changed_around_[at(w)] = true;
                }
            }
            if (moved.empty()) return;
            for (const std::size_t f : moved) find_normal(f);
        }
    }

  private:
    void find_normal(std::size_t f) {
        poll_();
        const auto& face = faces_[f];
        const Vec3 area = (points_[at(face[2])] - points_[at(face[0])])
                              .cross(points_[at(face[3])] - points_[at(face[1])]);
        const Vec3 middle = 0.25 * (points_[at(face[0])] + points_[at(face[1])] +
                                    points_[at(face[2])] + points_[at(face[3])]);
        const Vec3 side = area.normalized();
        const geom::FootPoint foot = side.allFinite() && side.norm() > 0.5
                                         ? reference_.foot_point(middle, side)
                                         : reference_.foot_point(middle);
        const double cosine = foot.normal.dot(side);
        normals_[f] = cosine > agrees || cosine < 0.0 ? foot.normal : side;
    }

    [[nodiscard]] double least_sine(std::size_t f) const {
        double least = 1.0;
        for (int k = 0; k < 4; ++k)
            least = std::min(least, corner_sine(points_, faces_[f], k, normals_[f]));
        return least;
    }

    /// Of the faces around a point, good_enough_face at most.
    [[nodiscard]] double worst_around(int v) const {
        double least = good_enough_face;
        for (const std::size_t f : around_[at(v)]) least = std::min(least, least_sine(f));
        return least;
    }

    [[nodiscard]] double reach(int v) const {
        double sum = 0.0;
        int count = 0;
        for (const std::size_t f : around_[at(v)]) {
            for (std::size_t k = 0; k < 4; ++k) {
                if (faces_[f][k] != v) continue;
                sum += (points_[at(faces_[f][(k + 1) % 4])] - points_[at(v)]).norm();
                ++count;
            }
        }
        return sum / std::max(count, 1);
    }

    bool improve(int v) {
        const Freedom& freedom = freedom_[at(v)];
        if (!freedom.free && freedom.curve < 0) return false;
        double best = worst_around(v), step = first_step * reach(v);
        Vec3 normal = Vec3::Zero();
        for (const std::size_t f : around_[at(v)]) normal += normals_[f];
        normal.normalize();
        if (!(normal.norm() > 0.5)) return false;
        const Vec3 across = normal.unitOrthogonal(), along = normal.cross(across);
        bool moved = false;
        for (int halving = 0; halving < step_halvings; ++halving, step *= 0.5) {
            if (best + least_gain >= good_enough_face) break;
            const Vec3 old = points_[at(v)];
            Vec3 best_point = old;
            for (int d = 0; d < directions; ++d) {
                poll_();
                const double angle = 2.0 * M_PI * d / directions;
                const Vec3 there =
                    old + step * (std::cos(angle) * across + std::sin(angle) * along);
                points_[at(v)] = freedom.free
                                     ? reference_.foot_point(there, normal).point
                                     : reference_.nearest_on_curve(freedom.curve, there).point;
                const double now = worst_around(v);
                if (now <= best + least_gain) continue;
                best = now;
                best_point = points_[at(v)];
            }
            points_[at(v)] = best_point;
            moved = moved || best_point != old;
        }
        return moved;
    }

    const std::vector<std::vector<int>>& faces_;
    std::vector<Vec3>& points_;
    const std::vector<Freedom>& freedom_;
    const geom::ModelSurface& reference_;
    Poll& poll_;
    std::vector<std::vector<std::size_t>> around_;
    std::vector<char> changed_around_;  ///< since a point was tried in vain
    std::vector<Vec3> normals_;
};

}  // namespace

double corner_sine(const std::vector<Vec3>& points, const std::vector<int>& face, int k,
                   const Vec3& normal) {
    const Vec3& p = points[at(face[at(k)])];
    const Vec3 a = (points[at(face[at((k + 1) % 4)])] - p).normalized();
    const Vec3 b = (points[at(face[at((k + 3) % 4)])] - p).normalized();
    return a.cross(b).dot(normal);
}

void untangle(const std::vector<std::vector<int>>& faces, std::vector<Vec3>& points,
              const std::vector<Freedom>& freedom, const geom::ModelSurface& reference,
              Poll& poll) {
    Untangler(faces, points, freedom, reference, poll).run();
}

}  // namespace patchwright::cage
