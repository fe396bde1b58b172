#include <patchwright/geom/curve_ends.h>

#include <algorithm>

namespace patchwright::geom {

CurveEnds curve_ends(const Features& features, double same_mm) {
    CurveEnds ends;
    for (const FeatureCorner& corner : features.corners) ends.points.push_back(corner.point);
    const auto corners = std::ptrdiff_t(features.corners.size());
    for (const FeatureCurve& curve : features.curves) {
        std::array<int, 2> places{curve.start_corner, curve.end_corner};
        for (std::size_t k = 0; k < 2 && !curve.closed; ++k) {
            if (places[k] >= 0) continue;
            const Vec3& end = k == 0 ? curve.start : curve.end;
            const auto known =
                std::find_if(ends.points.begin() + corners, ends.points.end(),
                             [&](const Vec3& p) { return (p - end).norm() < same_mm; });
            places[k] = int(known - ends.points.begin());
            if (known == ends.points.end()) ends.points.push_back(end);
        }
        ends.places.push_back(places);
    }
    ends.curves.resize(ends.points.size());
    for (std::size_t c = 0; c < ends.places.size(); ++c)
        for (std::size_t k = 0; k < 2; ++k)
            if (const int place = ends.places[c][k]; place >= 0)
                ends.curves[std::size_t(place)].push_back({int(c), k != 0});
    return ends;
}

}  // namespace patchwright::geom
