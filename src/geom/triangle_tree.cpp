#include "geom/triangle_tree.h"

#include <patchwright/base/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>

namespace patchwright::geom {

TriangleTree::TriangleTree(const std::vector<Corners>& triangles,
                           const std::vector<double>& reach) {
    if (triangles.size() != reach.size())
        throw base::InvalidArgument("triangle tree: one reach a triangle is needed");
    std::vector<Box3> boxes(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        for (const Vec3& p : triangles[i]) boxes[i].add(p);
        boxes[i].min.array() -= reach[i];
        boxes[i].max.array() += reach[i];
    }
    tree_ = Bvh(boxes, lanes);
    if (boxes.empty()) return;
    numbers_ = tree_.sort_items(lanes);
    centre_ = tree_.bounds().centre();
    const double extent = (tree_.bounds().max - tree_.bounds().min).maxCoeff();
    if (extent > 0.0) extent_ = extent;
    scale_ = 1.0 / extent_;
    blocks_.resize(numbers_.size() / lanes);
    std::memset(static_cast<void*>(blocks_.data()), 0, blocks_.size() * sizeof(Block));
    for (std::size_t slot = 0; slot < numbers_.size(); ++slot) {
        if (numbers_[slot] < 0) continue;
        Block& block = blocks_[slot / lanes];
        const std::size_t lane = slot % lanes;
        const auto put = [&](std::array<Lanes, 3>& to, const Vec3& value) {
            for (std::size_t k = 0; k < 3; ++k) to[k][lane] = float(value[Eigen::Index(k)]);
        };
        const auto& [a, b, c] = triangles[std::size_t(numbers_[slot])];
        const Vec3 ab = b - a, ac = c - a;
        const Vec3 normal = ab.cross(ac);
        const Vec3 along = ab.squaredNorm() > 0.0   ? Vec3(ab.normalized())
                           : ac.squaredNorm() > 0.0 ? Vec3(ac.normalized())
                                                    : Vec3(Vec3::UnitX());
        // Of a triangle without area any plane through it will do.
        const Vec3 up =
            normal.squaredNorm() > 0.0 ? Vec3(normal.normalized()) : Vec3(along.unitOrthogonal());
        const Vec3 across = up.cross(along).normalized();
        put(block.origin, scale_ * (a - centre_));
        put(block.along, along);
        put(block.across, across);
        const double length = scale_ * ab.norm();
        block.length[lane] = float(length);
        using Vec2 = Eigen::Vector2d;
        const auto side = [&](const Vec2& from, const Vec2& to) {
            const double size = (to - from).norm();
            const Vec2 unit = size > 0.0 ? Vec2((to - from) / size) : Vec2(1.0, 0.0);
            return Vec3(unit.x(), unit.y(), size);
        };
        const Vec2 third(scale_ * ac.dot(along), scale_ * ac.dot(across));
        put(block.side, side(Vec2::Zero(), third));
        put(block.far_side, side(Vec2(length, 0.0), third));
    }
}

Vec3 TriangleTree::weights_near(int slot, const Vec3& query) const {
    const Block& block = blocks_[std::size_t(slot) / lanes];
    const std::size_t lane = std::size_t(slot) % lanes;
    const auto get = [&](const std::array<Lanes, 3>& from) {
        return Eigen::Vector3f(from[0][lane], from[1][lane], from[2][lane]);
    };
    const Eigen::Vector3f r = (scale_ * (query - centre_)).cast<float>() - get(block.origin);
    const Eigen::Vector3f side = get(block.side);
    const Eigen::Vector2f third = side[2] * side.head<2>();
    const float c =
        std::clamp(third[1] > 0.0f ? r.dot(get(block.across)) / third[1] : 0.0f, 0.0f, 1.0f);
    const float length = block.length[lane];
    const float b = length > 0.0f ? (r.dot(get(block.along)) - c * third[0]) / length : 0.0f;
    const double at = std::clamp(b, 0.0f, 1.0f - c);
    return {1.0 - at - double(c), at, double(c)};
}

}  // namespace patchwright::geom
