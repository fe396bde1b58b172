#include "layout/feature_rings.h"

#include <patchwright/geom/curve_ends.h>

#include <algorithm>

namespace patchwright::layout {

using geom::FeatureKind;
using geom::Vec3;

std::vector<int> ring_through(int curve, const geom::ModelSurface& reference) {
    constexpr double same_rel = 1e-6, straight = 0.7;  // cosine
    const auto& curves = reference.features().curves;
    const geom::CurveEnds ends =
        geom::curve_ends(reference.features(), same_rel * reference.bounds().diagonal());
    // Unit, along the curve away from its start or towards its end.
    const auto tangent = [&](int c, bool at_end) {
        return reference.point_on_curve(c, at_end ? curves[std::size_t(c)].length : 0.0).tangent;
    };
    std::vector<int> chain{curve};
    const int first = ends.places[std::size_t(curve)][0];
    int at = ends.places[std::size_t(curve)][1];
    Vec3 direction = tangent(curve, true);
    while (at != first) {
        int next = -1;
        bool backwards = false;
        double best = straight;
        for (int c = 0; c < int(curves.size()); ++c) {
            if (curves[std::size_t(c)].kind == FeatureKind::Free ||
                std::find(chain.begin(), chain.end(), c) != chain.end())
                continue;
            for (const bool from_end : {false, true}) {
                if (ends.places[std::size_t(c)][from_end ? 1 : 0] != at) continue;
                const double cosine = (from_end ? -1.0 : 1.0) * tangent(c, from_end).dot(direction);
                if (cosine <= best) continue;
                best = cosine;
                next = c;
                backwards = from_end;
            }
        }
        if (next < 0) return {};
        chain.push_back(next);
        at = ends.places[std::size_t(next)][backwards ? 0 : 1];
        direction = (backwards ? -1.0 : 1.0) * tangent(next, !backwards);
    }
    return chain;
}

}  // namespace patchwright::layout
