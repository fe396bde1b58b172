#include "cage/sections/part_left_out.h"

#include "geom/bvh.h"

#include <patchwright/base/numbers.h>
#include <patchwright/geom/nearest.h>

#include <algorithm>
#include <array>
#include <vector>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Of the chord nearby. Faces of coarse cages come within a fortieth of it, at pointed tips, where
// the chord goes to nothing between two sections, within a quarter.
constexpr double left_out_chords = 1.0 / 3.0;

/// Nearest points of a cage's faces, each a fan of triangles.
class FaceTree {
  public:
    explicit FaceTree(const Blocks& blocks) {
        std::vector<geom::Box3> boxes;
        for (const auto& face : blocks.faces) {
            const auto corner = [&](std::size_t k) { return blocks.points[at(face[k])]; };
            for (std::size_t k = 1; k + 1 < face.size(); ++k) {
                triangles_.push_back({corner(0), corner(k), corner(k + 1)});
                boxes.emplace_back();
                for (const Vec3& p : triangles_.back()) boxes.back().add(p);
            }
        }
        tree_ = geom::Bvh(boxes);
    }

    [[nodiscard]] Vec3 nearest(const Vec3& query) const {
        Vec3 best = triangles_.front()[0];
        tree_.nearest(query, (best - query).norm(), [&](int t, double limit) {
            const auto& c = triangles_[at(t)];
            const Vec3 w = geom::nearest_weights(query, c);
            const Vec3 point = w[0] * c[0] + w[1] * c[1] + w[2] * c[2];
            const double distance = (point - query).norm();
            if (distance >= limit) return limit;
            best = point;
            return distance;
        });
        return best;
    }

  private:
    std::vector<std::array<Vec3, 3>> triangles_;
    geom::Bvh tree_;
};

/// The longer one of the sections on either side of a place.
double chord_near(const Wing& wing, const Vec3& place) {
    const double height = wing.slicer.spine().height(place);
    const auto after = std::lower_bound(wing.heights.begin(), wing.heights.end(), height);
    const std::size_t last = wing.heights.size() - 1;
    const std::size_t high = std::min(last, std::size_t(after - wing.heights.begin()));
    const std::size_t low = high > 0 ? high - 1 : 0;
    return std::max(wing.sections[low].chord, wing.sections[high].chord);
}

}  // namespace

std::optional<Vec3> part_left_out(const SurfaceBody& body, const Wing& wing, const Blocks& blocks,
                                  Poll& poll) {
    const FaceTree faces(blocks);
    std::optional<Vec3> worst;
    double most = left_out_chords;
    for (const int t : body.triangles) {
        poll();
        const auto& c = body.mesh->triangles[at(t)];
        const auto& points = body.mesh->points;
        const Vec3 middle = (points.row(c[0]) + points.row(c[1]) + points.row(c[2])) / 3.0;
        const Vec3 near = faces.nearest(middle);
        const double share = (near - middle).norm() / chord_near(wing, near);
        if (share <= most) continue;
        most = share;
        worst = middle;
    }
    return worst;
}

}  // namespace patchwright::cage
