// The nearest of many points.
#pragma once

#include "geom/bvh.h"

#include <vector>

namespace patchwright::adapt {

inline geom::Bvh tree_of_points(const geom::Points& points) {
    std::vector<geom::Box3> boxes(std::size_t(points.rows()));
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        boxes[std::size_t(i)].add(points.row(i).transpose());
    return geom::Bvh(boxes);
}

/// The first one of equally near ones, whatever the order of the tree.
inline int nearest_point(const geom::Bvh& tree, const geom::Points& points, const geom::Vec3& p) {
    int nearest = 0;
    double least = (points.row(0).transpose() - p).norm();
    tree.nearest(p, least, [&](int i, double bound) {
        const double distance = (points.row(i).transpose() - p).norm();
        if (distance < least || (distance == least && i < nearest)) {
            least = distance;
            nearest = i;
        }
        return std::min(bound, least);
    });
    return nearest;
}

}  // namespace patchwright::adapt
