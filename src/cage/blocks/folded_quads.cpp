#include "cage/blocks/folded_quads.h"

#include "cage/blocks/layout_refused.h"

#include <patchwright/base/numbers.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// A corner with a smaller sine counts as concave (1 degree); one may be, up to 210 degrees: the fit
// makes that good.
constexpr double least_convex = 0.02, most_concave = -0.5;
// Share of quads that fold above which finer ones are not worth their time.
constexpr double most_folded = 0.04;

const Vec3& corner(const Blocks& blocks, std::size_t face, int k) {
    return blocks.points[at(blocks.faces[face][at(k)])];
}

bool folds(const Blocks& blocks, std::size_t f, const geom::ModelSurface& reference) {
    const Vec3 normal = quad_area(blocks, f).normalized();
    int concave = 0;
    for (int k = 0; k < 4; ++k)
        concave += corner_sine(blocks.points, blocks.faces[f], k, normal) < least_convex;
    return concave > 1 || least_sine(blocks, f) < most_concave ||
           reference.foot_point(quad_middle(blocks, f), normal).normal.dot(normal) <= 0.0;
}

/// Quads must face as the model does and may be concave a little, at one corner. What has two such
/// corners is folded.
std::vector<std::size_t> folded_quads(const Blocks& blocks, const geom::ModelSurface& reference,
                                      Poll& poll) {
    std::vector<std::size_t> result;
    for (std::size_t f = 0; f < blocks.faces.size(); ++f) {
        poll();
        if (folds(blocks, f, reference)) result.push_back(f);
    }
    return result;
}

}  // namespace

Vec3 quad_area(const Blocks& blocks, std::size_t f) {
    return 0.5 * (corner(blocks, f, 2) - corner(blocks, f, 0))
                     .cross(corner(blocks, f, 3) - corner(blocks, f, 1));
}

Vec3 quad_middle(const Blocks& blocks, std::size_t f) {
    return 0.25 * (corner(blocks, f, 0) + corner(blocks, f, 1) + corner(blocks, f, 2) +
                   corner(blocks, f, 3));
}

double corner_sine(const std::vector<Vec3>& points, const std::vector<int>& face, int k,
                   const Vec3& normal) {
    const Vec3& p = points[at(face[at(k)])];
    const Vec3 a = (points[at(face[at((k + 1) % 4)])] - p).normalized();
    const Vec3 b = (points[at(face[at((k + 3) % 4)])] - p).normalized();
    return a.cross(b).dot(normal);
}

double least_sine(const Blocks& blocks, std::size_t f) {
    const Vec3 normal = quad_area(blocks, f).normalized();
    double least = 1.0;
    for (int k = 0; k < 4; ++k)
        least = std::min(least, corner_sine(blocks.points, blocks.faces[f], k, normal));
    return least;
}

Blocks checked(Blocks blocks, const geom::ModelSurface& reference,
               const std::vector<std::string>& face_names, Poll& poll) {
    const auto bad = folded_quads(blocks, reference, poll);
    if (!bad.empty()) {
        const Vec3 first = quad_middle(blocks, bad[0]);
        throw LayoutRefused{
            fmt::format("{} of {} quads fold, one near ({:.4g}, {:.4g}, {:.4g})", bad.size(),
                        blocks.faces.size(), first.x(), first.y(), first.z()),
            double(bad.size()) > most_folded * double(blocks.faces.size())};
    }
    for (std::size_t f = 0; f < blocks.faces.size(); ++f) {
        const geom::FootPoint foot =
            reference.foot_point(quad_middle(blocks, f), quad_area(blocks, f).normalized());
        blocks.groups.push_back(face_names[at(std::max(foot.face, 0))]);
    }
    return blocks;
}

}  // namespace patchwright::cage
