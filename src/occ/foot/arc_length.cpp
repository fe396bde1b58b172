#include "occ/foot/arc_length.h"

#include <GeomAdaptor_Curve.hxx>
#include <TColStd_Array1OfReal.hxx>

#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::occ {

namespace {

// Gauss-Legendre on [-1, 1] with six points; half of them, the others mirrored.
constexpr std::array<std::array<double, 2>, 3> gauss{{{0.2386191860831969, 0.4679139345726910},
                                                      {0.6612093864662645, 0.3607615730481386},
                                                      {0.9324695142031521, 0.1713244923791704}}};
constexpr double relative_error = 1e-12;
constexpr int max_depth = 16;

}  // namespace

ArcLength::ArcLength(const ModelEdge& edge) : curve_(edge.curve), t_{edge.first}, arc_{0.0} {
    const GeomAdaptor_Curve adaptor(edge.curve, edge.first, edge.last);
    TColStd_Array1OfReal breaks(1, adaptor.NbIntervals(GeomAbs_CN) + 1);
    adaptor.Intervals(breaks, GeomAbs_CN);
    for (int i = breaks.Lower(); i < breaks.Upper(); ++i)
        add(breaks(i), breaks(i + 1), integrate(breaks(i), breaks(i + 1)), 0);
}

double ArcLength::integrate(double a, double b) const {
    const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
    const auto speed = [&](double t) {
        gp_Pnt p;
        gp_Vec d;
        curve_->D1(t, p, d);
        return d.Magnitude();
    };
    double sum = 0.0;
    for (const auto& [x, weight] : gauss)
        sum += weight * (speed(middle - half * x) + speed(middle + half * x));
    return half * sum;
}

void ArcLength::add(double a, double b, double whole, int depth) {
    const double middle = 0.5 * (a + b);
    const double left = integrate(a, middle), right = integrate(middle, b);
    if (depth < max_depth && std::abs(left + right - whole) > relative_error * whole) {
        add(a, middle, left, depth + 1);
        add(middle, b, right, depth + 1);
        return;
    }
    t_.push_back(b);
    arc_.push_back(arc_.back() + left + right);
}

double ArcLength::at(double t) const {
    const auto next = std::upper_bound(t_.begin() + 1, t_.end() - 1, t);
    const auto i = std::size_t(next - t_.begin());
    return std::clamp(arc_[i - 1] + integrate(t_[i - 1], t), arc_[i - 1], arc_[i]);
}

double ArcLength::parameter(double arc) const {
    if (arc <= 0.0) return t_.front();
    if (arc >= length()) return t_.back();
    const auto next = std::upper_bound(arc_.begin() + 1, arc_.end() - 1, arc);
    const auto i = std::size_t(next - arc_.begin());
    double low = t_[i - 1], high = t_[i];
    double t = low + (high - low) * (arc - arc_[i - 1]) / (arc_[i] - arc_[i - 1]);
    // Newton, kept between the ends that are known to be on either side.
    for (int k = 0; k < 50; ++k) {
        const double off = arc_[i - 1] + integrate(t_[i - 1], t) - arc;
        (off > 0.0 ? high : low) = t;
        if (std::abs(off) <= 1e-14 * length()) break;
        gp_Pnt p;
        gp_Vec d;
        curve_->D1(t, p, d);
        const double newton = t - off / d.Magnitude();
        const double to = newton > low && newton < high ? newton : 0.5 * (low + high);
        if (to == t) break;
        t = to;
    }
    return t;
}

}  // namespace patchwright::occ
