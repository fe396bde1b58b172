#include "measure/normal_agreement.h"

#include "geom/angle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::measure {

using geom::Vec3;

double NormalAgreement::angle_at_foot(const Vec3& point, const Vec3& normal) const {
    const Vec3 at_foot = input_.foot_point(point).normal;
    return at_foot.isZero() ? M_PI : geom::angle_between(at_foot, sign_ * normal);
}

double NormalAgreement::least_angle(const Vec3& point, const Vec3& normal) const {
    const geom::FootPoint plain = input_.foot_point(point);
    const double reach = plain.distance + 2.0 * tolerance_;
    const Vec3 side = sign_ * normal;
    double least = M_PI;
    const auto agrees = [&](const geom::FootPoint& foot) {
        if (!foot.normal.isZero() && (foot.point - point).norm() <= reach)
            least = std::min(least, geom::angle_between(foot.normal, side));
        return least <= limit_;
    };
    if (agrees(plain) || agrees(input_.foot_point(point, side))) return least;
    // Of a displaced point the foot may be on another face of an edge or a tight bend; it is
    // within reach by the triangle inequality.
    const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
    for (const Vec3& way : std::array<Vec3, 10>{
             normal, Vec3(-normal), u, Vec3(-u), v, Vec3(-v), Vec3((u + v) * M_SQRT1_2),
             Vec3((u - v) * M_SQRT1_2), Vec3((v - u) * M_SQRT1_2), Vec3((u + v) * -M_SQRT1_2)}) {
        const Vec3 probe = point + tolerance_ * way;
        if (agrees(input_.foot_point(probe, side)) || agrees(input_.foot_point(probe)))
            return least;
    }
    return least;
}

}  // namespace patchwright::measure
