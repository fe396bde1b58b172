#include "measure/crease_distance.h"

#include <algorithm>

namespace patchwright::measure {

using geom::FeatureKind;

std::vector<int> kinked_curves(const geom::ModelSurface& model, double least_angle_rad) {
    std::vector<int> kinked;
    const auto& curves = model.features().curves;
    for (std::size_t i = 0; i < curves.size(); ++i)
        if (curves[i].kind == FeatureKind::Smooth && curves[i].greatest_angle_rad > least_angle_rad)
            kinked.push_back(int(i));
    return kinked;
}

CreaseDistance::CreaseDistance(const geom::ModelSurface& model, double least_angle_rad)
    : model_(model), kinked_(kinked_curves(model, least_angle_rad)) {}

bool CreaseDistance::is_within(const geom::Vec3& point, double reach_mm) const {
    for (const FeatureKind kind : {FeatureKind::Sharp, FeatureKind::Free}) {
        const auto nearest = model_.feature_point(point, kind);
        if (nearest && nearest->distance < reach_mm) return true;
    }
    return std::any_of(kinked_.begin(), kinked_.end(), [&](int i) {
        const geom::FeatureCurve& curve = model_.features().curves[std::size_t(i)];
        return (curve.start - point).norm() < curve.length + reach_mm &&
               model_.nearest_on_curve(i, point).distance < reach_mm;
    });
}

}  // namespace patchwright::measure
