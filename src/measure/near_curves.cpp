#include "measure/near_curves.h"

#include <patchwright/geom/nearest.h>

#include <algorithm>
#include <cmath>

namespace patchwright::measure {

using geom::Vec3;

NearCurves::NearCurves(const geom::ReferenceSurface& shape,
                       const std::vector<geom::BsplineCurve>& curves, double reach_mm)
    : shape_(shape), reach_(reach_mm) {
    add_features();
    for (const geom::BsplineCurve& curve : curves) add_curve(curve);
    std::vector<geom::Box3> boxes;
    for (const Arc& arc : arcs_) {
        // No point of an arc is farther from its middle than half of its length.
        const double half = 0.5 * (arc.range.to - arc.range.from);
        const Vec3 middle = shape_.point_on_curve(arc.curve, arc.range.from + half).point;
        boxes.push_back({middle - Vec3::Constant(half), middle + Vec3::Constant(half)});
    }
    for (const auto& [a, b] : segments_) boxes.push_back({a.cwiseMin(b), a.cwiseMax(b)});
    if (!boxes.empty()) tree_ = geom::Bvh(boxes);
}

void NearCurves::add_features() {
    constexpr int arcs_a_curve = 64;  // boxes of 64 arcs exclude nearly all curves that are far
    const geom::Features& features = shape_.features();
    for (std::size_t i = 0; i < features.curves.size(); ++i) {
        const geom::FeatureCurve& curve = features.curves[i];
        if (curve.kind == geom::FeatureKind::Smooth) continue;
        for (int k = 0; k < arcs_a_curve; ++k)
            arcs_.push_back(
                {int(i), {curve.length * k / arcs_a_curve, curve.length * (k + 1) / arcs_a_curve}});
    }
    for (const geom::FeatureCorner& corner : features.corners)
        segments_.push_back({corner.point, corner.point});
}

void NearCurves::add_curve(const geom::BsplineCurve& curve) {
    for (Eigen::Index span = 3; span + 4 < Eigen::Index(curve.knots.size()); ++span) {
        const double begin = curve.knots[std::size_t(span)],
                     end = curve.knots[std::size_t(span) + 1];
        if (!(begin < end)) continue;
        const Eigen::Matrix<double, 4, 3> b =
            geom::bezier_matrix(curve.knots, span) * curve.points.middleRows<4>(span - 3);
        // A chord of 1/n of the span is within |C''| / (8 n^2) of the curve.
        const double bend = 6.0 * std::max((b.row(0) - 2.0 * b.row(1) + b.row(2)).norm(),
                                           (b.row(1) - 2.0 * b.row(2) + b.row(3)).norm());
        constexpr double chord_error = 0.01, most = 1000.0;  // of the reach
        const int n =
            int(std::clamp(std::ceil(std::sqrt(bend / (8.0 * chord_error * reach_))), 1.0, most));
        for (int k = 0; k < n; ++k)
            segments_.push_back({curve.at(begin + (end - begin) * k / n),
                                 curve.at(begin + (end - begin) * (k + 1) / n)});
    }
}

bool NearCurves::is_near(const Vec3& p) const {
    bool found = false;
    tree_.nearest(p, reach_, [&](int item, double bound) {
        const auto k = std::size_t(item);
        double distance = 0.0;
        if (k < arcs_.size()) {
            distance = shape_.nearest_on_curve(arcs_[k].curve, p, arcs_[k].range).distance;
        } else {
            const auto& [a, b] = segments_[k - arcs_.size()];
            distance = (geom::nearest_on_segment(p, a, b).point - p).norm();
        }
        found = distance <= reach_;
        return found ? -1.0 : bound;
    });
    return found;
}

}  // namespace patchwright::measure
