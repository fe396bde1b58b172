#include <patchwright/geom/nearest.h>

namespace patchwright::geom {

Vec3 nearest_weights(const Vec3& p, const std::array<Vec3, 3>& corner) {
    // Voronoi regions of the corners, then of the sides, then the plane.
    const auto& [a, b, c] = corner;
    const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp),
                 d5 = ab.dot(cp), d6 = ac.dot(cp);
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    Vec3 w;
    if (d1 <= 0.0 && d2 <= 0.0) {
        w = {1, 0, 0};
    } else if (d3 >= 0.0 && d4 <= d3) {
        w = {0, 1, 0};
    } else if (d6 >= 0.0 && d5 <= d6) {
        w = {0, 0, 1};
    } else if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        const double s = d1 / (d1 - d3);
        w = {1 - s, s, 0};
    } else if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        const double s = d2 / (d2 - d6);
        w = {1 - s, 0, s};
    } else if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
        const double s = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        w = {0, 1 - s, s};
    } else {
        w = Vec3(va, vb, vc) / (va + vb + vc);
    }
    return w.allFinite() ? w : Vec3(1, 0, 0);
}

}  // namespace patchwright::geom
