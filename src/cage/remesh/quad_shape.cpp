#include "cage/remesh/quad_shape.h"

#include "geom/angle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Cosine of the angle by which a quad may bend: 60 degrees.
constexpr double most_bent_cosine = 0.5;
// The widest corner of one face, 150 degrees: a sector that is wider needs two faces.
constexpr double widest_corner_rad = 2.6;
// The widest sector of two faces, 210 degrees. The surface at a corner between sharp edges d1, d2
// with one edge e between them follows, after k steps, e + k (d1 + d2) / 6: in a wider sector that
// turns over the sharp edges within a thousandth of e.
constexpr double widest_pair_rad = 3.67;
// The widest face of several at a corner, 120 degrees.
constexpr double widest_of_several_rad = 2.1;

}  // namespace

double quad_quality(const std::array<geom::Vec3, 4>& p) {
    const Vec3 one = (p[1] - p[0]).cross(p[2] - p[0]), two = (p[2] - p[0]).cross(p[3] - p[0]);
    const Vec3 other = (p[2] - p[1]).cross(p[3] - p[1]), fourth = (p[3] - p[1]).cross(p[0] - p[1]);
    const auto cosine = [](const Vec3& a, const Vec3& b) {
        const double norm = a.norm() * b.norm();
        return norm > 0.0 ? a.dot(b) / norm : -1.0;
    };
    const double flat = std::min(cosine(one, two), cosine(other, fourth));
    if (flat < most_bent_cosine) return 0.0;
    const Vec3 normal = (one + two).normalized();
    double worst = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
        const Vec3 a = p[(k + 1) % 4] - p[k], b = p[(k + 3) % 4] - p[k];
        double angle = std::atan2(normal.dot(a.cross(b)), a.dot(b));
        if (angle < 0.0) angle += 2.0 * M_PI;
        worst = std::max(worst, std::abs(angle - 0.5 * M_PI));
    }
    return std::max(0.0, 1.0 - worst / (0.5 * M_PI)) * (flat - most_bent_cosine) /
           (1.0 - most_bent_cosine);
}

double triangle_quality(const std::array<geom::Vec3, 3>& p) {
    double least = M_PI;
    for (std::size_t k = 0; k < 3; ++k)
        least = std::min(least, geom::angle_between(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]));
    return least / (M_PI / 3.0);
}

int least_faces(geom::VertexKind kind, bool on_boundary, double angle_rad) {
    if (kind == geom::VertexKind::Smooth) return on_boundary ? 1 : 3;
    // Along a smooth curve the sector is half a disc however its chords turn.
    if (kind == geom::VertexKind::Curve) return 2;
    return angle_rad > widest_pair_rad ? 3 : angle_rad > widest_corner_rad ? 2 : 1;
}

double evenness(double angle_rad) {
    return std::clamp((M_PI - angle_rad) / (M_PI - widest_of_several_rad), 0.0, 1.0);
}

bool is_even_enough(geom::VertexKind kind, double angle_rad, double sector_angle_rad) {
    return kind != geom::VertexKind::Fixed || sector_angle_rad < widest_corner_rad ||
           angle_rad < widest_of_several_rad;
}

}  // namespace patchwright::cage
