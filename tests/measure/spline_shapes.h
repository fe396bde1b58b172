// B-spline surfaces for tests of measurements.
#pragma once

#include <patchwright/geom/bspline.h>

#include <cmath>
#include <functional>
#include <vector>

namespace patchwright::test {

/// Clamped, `spans` equal spans over [0, 1].
inline std::vector<double> uniform_knots(int spans) {
    std::vector<double> knots(3, 0.0);
    for (int k = 0; k <= spans; ++k) knots.push_back(double(k) / spans);
    knots.insert(knots.end(), 3, 1.0);
    return knots;
}

/// Control points are points of the shape at the knots' Greville abscissae (Schoenberg's
/// approximation: exact for linear functions, keeps positions at corners and closed sides).
inline geom::BsplineSurface spline_surface(int spans_u, int spans_v,
                                           const std::function<geom::Vec3(double, double)>& at) {
    geom::BsplineSurface s{uniform_knots(spans_u), uniform_knots(spans_v), {}};
    s.points.resize(s.rows() * s.columns(), 3);
    const auto greville = [](const std::vector<double>& knots, Eigen::Index i) {
        const auto k = std::size_t(i);
        return (knots[k + 1] + knots[k + 2] + knots[k + 3]) / 3.0;
    };
    for (Eigen::Index i = 0; i < s.rows(); ++i) {
        for (Eigen::Index j = 0; j < s.columns(); ++j)
            s.point(i, j) = at(greville(s.knots_u, i), greville(s.knots_v, j)).transpose();
    }
    return s;
}

}  // namespace patchwright::test
