#include "cage/blocks/feature_chain.h"

#include <patchwright/geom/curve_ends.h>

#include <algorithm>

namespace patchwright::cage {

using geom::FeatureKind;
using geom::Vec3;

FeatureChain chain_from(int curve, bool backwards, const geom::ModelSurface& reference) {
    // Of the diagonal: ends this near are one place. Cosine of the turn, 45 degrees, up to which a
    // chain goes on.
    constexpr double same_rel = 1e-6, straight = 0.7;
    const auto& curves = reference.features().curves;
    const geom::CurveEnds ends =
        geom::curve_ends(reference.features(), same_rel * reference.size());
    // Unit, along the curve away from its start or towards its end.
    const auto tangent = [&](int c, bool at_end) {
        return reference.point_on_curve(c, at_end ? curves[std::size_t(c)].length : 0.0).tangent;
    };
    FeatureChain chain{{curve}};
    std::vector<int>& members = chain.curves;
    const int first = ends.places[std::size_t(curve)][backwards ? 1 : 0];
    int at = ends.places[std::size_t(curve)][backwards ? 0 : 1];
    Vec3 direction = (backwards ? -1.0 : 1.0) * tangent(curve, !backwards);
    while (at != first) {
        int next = -1;
        double best = straight;
        for (int c = 0; c < int(curves.size()); ++c) {
            if (curves[std::size_t(c)].kind == FeatureKind::Free ||
                std::find(members.begin(), members.end(), c) != members.end())
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
        if (next < 0) return chain;
        members.push_back(next);
        at = ends.places[std::size_t(next)][backwards ? 0 : 1];
        direction = (backwards ? -1.0 : 1.0) * tangent(next, !backwards);
    }
    chain.closed = true;
    return chain;
}

}  // namespace patchwright::cage
