// Figures of single cells, and their gathering.
#pragma once

#include <patchwright/grid/quality.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::grid {

inline double angle(const geom::Vec3& a, const geom::Vec3& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

inline double ratio(double a, double b) { return a > b ? a / b : b / a; }

/// Of a quad. Angles are radians.
struct CellFigures {
    double min_angle = 0.0, skewness = 1.0, aspect = 1.0, area = 0.0;
    bool folded = false;
};

inline CellFigures quad_figures(const std::array<geom::Vec3, 4>& p) {
    CellFigures f;
    const geom::Vec3 normal = (p[2] - p[0]).cross(p[3] - p[1]);
    f.area = 0.5 * normal.norm();
    double low = M_PI, high = 0.0;
    std::array<double, 4> length{};
    for (std::size_t k = 0; k < 4; ++k) {
        const geom::Vec3 on = p[(k + 1) % 4] - p[k], back = p[(k + 3) % 4] - p[k];
        length[k] = on.norm();
        const geom::Vec3 corner = on.cross(back);
        const double a = std::atan2(corner.norm(), on.dot(back));
        low = std::min(low, a);
        high = std::max(high, a);
        f.folded = f.folded || corner.dot(normal) <= 0.0;
    }
    f.min_angle = low;
    f.skewness = std::max((high - M_PI_2) / M_PI_2, (M_PI_2 - low) / M_PI_2);
    f.aspect = ratio(length[0] + length[2], length[1] + length[3]);
    return f;
}

/// Keeps sums apart from extremes until the end. `larger` tells what is worse.
inline void note(Spread& spread, bool larger, double value, int block, int i, int j, int k,
                 const geom::Vec3& at) {
    if (spread.count == 0 || (larger ? value > spread.worst : value < spread.worst)) {
        spread.worst = value;
        spread.block = block;
        spread.i = i;
        spread.j = j;
        spread.k = k;
        spread.at = at;
    }
    spread.mean += value;
    ++spread.count;
}

/// As if what `part` holds had been noted after what `all` does.
inline void merge(Spread& all, const Spread& part, bool larger) {
    if (part.count == 0) return;
    const double sum = all.mean + part.mean;
    const std::int64_t count = all.count + part.count;
    if (all.count == 0 || (larger ? part.worst > all.worst : part.worst < all.worst)) all = part;
    all.mean = sum;
    all.count = count;
}

/// With the mean in place of the sum.
inline Spread finished(Spread spread) {
    if (spread.count > 0) spread.mean /= double(spread.count);
    return spread;
}

}  // namespace patchwright::grid
