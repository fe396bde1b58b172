#include <patchwright/base/error.h>
#include <patchwright/geom/model_surface.h>

#include <algorithm>
#include <cmath>

namespace patchwright::geom {

std::vector<CurveSample> ModelSurface::sample_curves(FeatureKind kind, double spacing_mm) const {
    if (!(spacing_mm > 0.0))
        throw base::InvalidArgument("sample_curves: the spacing must be positive");
    std::vector<CurveSample> samples;
    for (std::size_t i = 0; i < features().curves.size(); ++i) {
        const FeatureCurve& curve = features().curves[i];
        if (curve.kind != kind) continue;
        constexpr double most = 1e5;
        const int pieces = std::max(2, int(std::min(std::ceil(curve.length / spacing_mm), most)));
        for (int k = 0; k <= pieces; ++k) {
            const double weight = curve.length / pieces * (k == 0 || k == pieces ? 0.5 : 1.0);
            const double arc = curve.length * k / pieces;
            samples.push_back({point_on_curve(int(i), arc).point, int(i), weight});
        }
    }
    return samples;
}

}  // namespace patchwright::geom
