#include "cage/remesh/curve_ways.h"

#include <cmath>

namespace patchwright::cage {

double CurveWays::arc_at(int curve, const geom::Vec3& p) const {
    poll_();
    return reference_.nearest_on_curve(curve, p).arc_length;
}

double CurveWays::way(int curve, double from, double to) const {
    const geom::FeatureCurve& c = reference_.features().curves[std::size_t(curve)];
    return c.closed ? std::remainder(to - from, c.length) : to - from;
}

geom::Vec3 CurveWays::middle(int curve, const geom::Vec3& a, const geom::Vec3& b) const {
    const double from = arc_at(curve, a);
    const double along = way(curve, from, arc_at(curve, b));
    return reference_.point_on_curve(curve, from + 0.5 * along).point;
}

}  // namespace patchwright::cage
