#include "measure/direction_cone.h"

#include <algorithm>
#include <cmath>

namespace patchwright::measure {

using geom::Vec3;

namespace {

DirectionCone around(const Vec3& axis, double angle) {
    const double bounded = std::min(angle, M_PI);
    return {axis, std::cos(bounded), std::sin(bounded)};
}

}  // namespace

DirectionCone cone_of(const Directions& vectors, Eigen::Index count) {
    Vec3 sum = Vec3::Zero();
    Directions unit;
    for (Eigen::Index i = 0; i < count; ++i) {
        unit.row(i) = vectors.row(i).normalized();
        sum += unit.row(i).transpose();
    }
    if (count == 0) return {};
    const double length = sum.norm();
    if (!(length > 1e-9)) return around(Vec3::UnitX(), M_PI);
    const Vec3 axis = sum / length;
    constexpr double rounding = 1e-14;
    double least = 1.0;
    for (Eigen::Index i = 0; i < count; ++i) least = std::min(least, unit.row(i).dot(axis));
    const double cosine = std::max(least - rounding, -1.0);
    return {axis, cosine, std::sqrt(1.0 - cosine * cosine)};
}

DirectionCone merge(const DirectionCone& a, const DirectionCone& b) {
    if (a.empty()) return b;
    if (b.empty()) return a;
    const double angle_a = std::atan2(a.sine, a.cosine), angle_b = std::atan2(b.sine, b.cosine);
    const double between = 2.0 * std::atan2((a.axis - b.axis).norm(), (a.axis + b.axis).norm());
    if (between + angle_b <= angle_a) return a;
    if (between + angle_a <= angle_b) return b;
    const double angle = 0.5 * (between + angle_a + angle_b);
    if (!(angle < M_PI)) return around(a.axis, M_PI);
    const double turn = angle - angle_a;  // of a's axis towards b's
    Vec3 across = b.axis - a.axis.dot(b.axis) * a.axis;
    const double size = across.norm();
    if (!(size > 1e-12)) return around(a.axis, angle + turn);
    across /= size;
    return around(std::cos(turn) * a.axis + std::sin(turn) * across, angle + 1e-12);
}

bool share_half_space(std::initializer_list<DirectionCone> cones) {
    // Gilbert's algorithm (1966) for the point of the vectors' convex hull that is nearest to the
    // origin: as a direction it makes the largest least product with them.
    constexpr int steps = 8;         // more settle hardly any pair of pieces that a split does not
    constexpr double margin = 1e-4;  // radians that decide nothing
    Vec3 w = Vec3::Zero();
    int count = 0;
    for (const DirectionCone& cone : cones) {
        if (cone.empty()) continue;
        if (!(cone.cosine > margin)) return false;
        w += cone.axis;
        ++count;
    }
    if (count == 0) return true;
    w /= count;
    for (int step = 0; step < steps; ++step) {
        const double length = w.norm();
        if (!(length > margin)) return false;
        const Vec3 way = w / length;
        double least = 2.0;
        Vec3 farthest = Vec3::Zero();
        for (const DirectionCone& cone : cones) {
            if (cone.empty()) continue;
            const double c = cone.axis.dot(way);
            const Vec3 across = way - c * cone.axis;
            const double s = across.norm();
            // cos(angle to the axis + angle of the cone), -1 beyond the opposite.
            const double product = c <= -cone.cosine ? -1.0 : c * cone.cosine - s * cone.sine;
            if (product >= least) continue;
            least = product;
            farthest = cone.cosine * cone.axis;
            if (s > 1e-12) farthest -= cone.sine / s * across;
        }
        if (least > margin) return true;
        const Vec3 change = farthest - w;
        const double share = std::clamp(-w.dot(change) / change.squaredNorm(), 0.0, 1.0);
        if (!(share > 0.0)) return false;
        w += share * change;
    }
    return false;
}

}  // namespace patchwright::measure
