#include <patchwright/geom/curve_ends.h>

#include <algorithm>

namespace patchwright::geom {

CurveEnds curve_ends(const Features& features, double same_mm) {
    CurveEnds ends;
    const auto corners = int(features.corners.size());
    std::vector<Vec3> others;
    for (const FeatureCurve& curve : features.curves) {
        std::array<int, 2> places{curve.start_corner, curve.end_corner};
        for (std::size_t k = 0; k < 2 && !curve.closed; ++k) {
            if (places[k] >= 0) continue;
            const Vec3& end = k == 0 ? curve.start : curve.end;
            const auto known = std::find_if(others.begin(), others.end(), [&](const Vec3& p) {
                return (p - end).norm() < same_mm;
            });
            places[k] = corners + int(known - others.begin());
            if (known == others.end()) others.push_back(end);
        }
        ends.places.push_back(places);
    }
    ends.count = corners + int(others.size());
    return ends;
}

}  // namespace patchwright::geom
