#include "fit/loop/projection.h"

#include <algorithm>

namespace patchwright::fit {

namespace {

// Below this Jacobian ratio a face is about to be inverted by one of the next steps.
constexpr double min_jacobian_ratio = 0.1;
// Least weight of a sample with a doubtful foot point: with 0 its face would have no target.
constexpr double min_sample_weight = 0.1;
// A foot point jumps when it moves by more than this times the way of its sample.
constexpr double usual_foot_motion = 3.0;
// Cosine of the angle between normals beyond which a foot point is on the far side.
constexpr double opposing_cosine = -0.5;

}  // namespace

Projection::Projection(const subd::LimitOperator& samples, const geom::Points& points) {
    samples.apply(points, limit);
    target.resize(limit.rows(), 3);
    weights.direction = geom::Points::Zero(limit.rows(), 3);
    weights.weight = Eigen::VectorXd::Ones(limit.rows());
    jacobian_ratio.resize(limit.rows());
}

bool Projection::is_nearly_inverted(Eigen::Index i) const {
    return jacobian_ratio[i] < min_jacobian_ratio;
}

void Projection::sum_up() {
    for (Eigen::Index i = 0; i < limit.rows(); ++i)
        distances.add((limit.row(i) - target.row(i)).norm(), limit.row(i).transpose());
}

geom::FootPoint oriented_foot_point(const geom::ReferenceSurface& reference,
                                    const geom::Vec3& point,
                                    const std::optional<geom::Vec3>& normal, double reach,
                                    const std::vector<char>* part) {
    const auto foot_point = [&](const std::optional<geom::Vec3>& side) {
        const geom::FootPoint foot = reference.foot_point(point, side);
        const bool elsewhere =
            part != nullptr && foot.face >= 0 && (*part)[std::size_t(foot.face)] == 0;
        return elsewhere ? reference.foot_point_on(*part, point, side) : foot;
    };
    const geom::FootPoint nearest = foot_point(std::nullopt);
    if (!normal || nearest.normal.dot(*normal) > opposing_cosine) return nearest;
    const geom::FootPoint facing = foot_point(normal);
    return facing.distance <= reach ? facing : nearest;
}

double sample_weight(const Projection& p, const Projection* last, Eigen::Index row, double cosine,
                     double tolerance_mm) {
    // Full weight up to 60 degrees between the normals.
    const double agreement = std::clamp(2.0 * cosine, min_sample_weight, 1.0);
    if (last == nullptr) return agreement;
    const double moved = (p.limit.row(row) - last->limit.row(row)).norm();
    const double jump = (p.target.row(row) - last->target.row(row)).norm();
    const double usual = usual_foot_motion * moved + tolerance_mm;
    return agreement * std::clamp(usual / std::max(jump, 1e-300), min_sample_weight, 1.0);
}

Inversion inverted_by_step(const std::vector<std::int32_t>& rows, const Projection& now,
                           const Projection& next) {
    Inversion result;
    std::int64_t more = 0;
    for (std::size_t site = 0; site + 1 < rows.size(); ++site) {
        bool any = false;
        for (auto i = rows[site]; i < rows[site + 1]; ++i) {
            any = any || next.is_nearly_inverted(i);
            if (next.is_inverted(i) == now.is_inverted(i)) continue;
            // Unless the sample itself has turned or left the reference, as over an edge, only its
            // foot point has changed sides.
            const double was = (now.limit.row(i) - now.target.row(i)).norm();
            const double is = (next.limit.row(i) - next.target.row(i)).norm();
            const bool left = !next.of_curves && (next.is_inverted(i) ? is > was : was > is);
            if (left || next.normals.row(i).dot(now.normals.row(i)) < 0.0)
                more += next.is_inverted(i) ? 1 : -1;
        }
        if (any) result.sites.push_back(site);
    }
    result.more = more > 0;
    return result;
}

}  // namespace patchwright::fit
