#include "cage/sections/part_left_out.h"

#include "geom/triangle_tree.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <vector>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Of the chord nearby. Faces of coarse cages come within a fortieth of it, at pointed tips, where
// the chord goes to nothing between two sections, within a quarter.
constexpr double left_out_chords = 1.0 / 3.0;

class FaceTree {
  public:
    explicit FaceTree(const Blocks& blocks) {
        for (const auto& face : blocks.faces) {
            const auto corner = [&](std::size_t k) { return blocks.points[at(face[k])]; };
            for (std::size_t k = 1; k + 1 < face.size(); ++k)
                triangles_.push_back({corner(0), corner(k), corner(k + 1)});
        }
        tree_ = geom::TriangleTree(triangles_, std::vector<double>(triangles_.size(), 0.0));
    }

    [[nodiscard]] Vec3 nearest(const Vec3& query) const {
        Vec3 best = triangles_.front()[0];
        double distance = (best - query).norm();
        tree_.nearest(query, distance, [&](int first, int count, const auto& near, double) {
            for (int i = 0; i < count; ++i) {
                if (double(near.distance[at(i)]) >= distance) continue;
                const Vec3 weights = tree_.weights_near(first + i, query);
                const auto& c = triangles_[at(tree_.numbers()[at(first + i)])];
                best = weights[0] * c[0] + weights[1] * c[1] + weights[2] * c[2];
                distance = (best - query).norm();
            }
            return distance;
        });
        return best;
    }

  private:
    std::vector<geom::TriangleTree::Corners> triangles_;
    geom::TriangleTree tree_;
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
