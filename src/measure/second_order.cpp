#include "measure/second_order.h"

#include <algorithm>
#include <cmath>

namespace patchwright::measure {

using geom::Vec3;

namespace {

/// Cosine of 45 degrees: an arc that turns by that is 4 % higher than the parabola with its normals
/// (second_order_test.cpp).
constexpr double least_smooth_cosine = 0.7071;
/// A parabola over a chord is as high as an eighth of its second difference; over a triangle whose
/// three sides have the same one, a sixth.
constexpr double parabola_height = 1.0 / 8.0, triangle_by_side = 8.0 / 6.0;

bool smooth_between(const SurfaceShape& a, const SurfaceShape& b) {
    return a.normal.dot(b.normal) > least_smooth_cosine;
}

/// Second difference along a chord that starts at the point, by its normal and by its curvature.
double by_normal(const SurfaceShape& at, const Vec3& chord) { return 2.0 * chord.dot(at.normal); }

double by_curvature(const SurfaceShape& at, const Vec3& chord) {
    double sum = 0.0;
    for (std::size_t k = 0; k < 2; ++k)
        sum += at.curvature->value[k] * std::pow(chord.dot(at.curvature->direction[k]), 2);
    return sum;
}

/// Of one surface above a chord.
double height(const SurfaceShape& a, const SurfaceShape& b) {
    const Vec3 chord = b.point - a.point;
    const double off_a = std::abs(by_normal(a, chord)), off_b = std::abs(by_normal(b, chord));
    const double bent = parabola_height * std::max(std::abs(by_curvature(a, chord)),
                                                   std::abs(by_curvature(b, chord)));
    if (smooth_between(a, b)) return std::max(bent, parabola_height * std::max(off_a, off_b));
    return bent + 0.5 * std::min(off_a, off_b);
}

/// Of the one surface above the chord of the points, less that of the other above that of the feet.
double height_difference(const ShapePair& a, const ShapePair& b) {
    if (!smooth_between(a.point, b.point) || !smooth_between(a.foot, b.foot))
        return height(a.point, b.point) + height(a.foot, b.foot);
    const Vec3 chord = b.point.point - a.point.point, feet = b.foot.point - a.foot.point;
    double largest = 0.0;
    for (const ShapePair* end : {&a, &b}) {
        const double sign = end == &a ? 1.0 : -1.0;
        for (const auto second : {by_normal, by_curvature}) {
            const Vec3 difference = second(end->point, sign * chord) * end->point.normal -
                                    second(end->foot, sign * feet) * end->foot.normal;
            largest = std::max(largest, difference.norm());
        }
    }
    return parabola_height * largest;
}

}  // namespace

std::optional<double> interpolation_error(const std::array<const ShapePair*, 3>& corners) {
    for (const ShapePair* corner : corners) {
        for (const SurfaceShape* shape : {&corner->point, &corner->foot})
            if (!shape->curvature || shape->normal.isZero(0.0)) return std::nullopt;
    }
    double largest = 0.0;
    for (std::size_t k = 0; k < 3; ++k)
        largest = std::max(largest, height_difference(*corners[k], *corners[(k + 1) % 3]));
    return triangle_by_side * largest;
}

}  // namespace patchwright::measure
