#include "grid/edge_curve.h"

#include <algorithm>
#include <cmath>

namespace patchwright::grid {

subd::LimitPoint EdgeCurve::evaluate(double t, int order, int& side) const {
    const auto k = std::min(std::size_t(t), edge_.run.size() - 1);
    const double f = t - double(k);
    const mesh::CornerId c = edge_.run[k];
    const mesh::FaceId face = cage_.topology->face(c);
    side = c.value - cage_.topology->corners(face)[0].value;
    subd::Location at{face, f, 0.0};
    if (side == 1) at = {face, 1.0, f};
    if (side == 2) at = {face, 1.0 - f, 1.0};
    if (side == 3) at = {face, 0.0, 1.0 - f};
    return limit_.evaluate(cage_.points, at, order);
}

geom::Vec3 EdgeCurve::at(double t) const {
    int side = 0;
    return evaluate(t, 0, side).position;
}

EdgeCurve::Derivatives EdgeCurve::derivatives(double t) const {
    int side = 0;
    const subd::LimitPoint p = evaluate(t, 2, side);
    const double sign = side < 2 ? 1.0 : -1.0;
    if (side % 2 == 0) return {p.position, sign * p.du, p.duu};
    return {p.position, sign * p.dv, p.dvv};
}

std::vector<double> EdgeCurve::breaks() const {
    const mesh::Topology& t = *cage_.topology;
    std::vector<double> breaks{0.0};
    for (std::size_t k = 0; k < edge_.run.size(); ++k) {
        const mesh::CornerId c = edge_.run[k];
        const double start = double(k);
        // Towards an extraordinary vertex derivatives are those of a power.
        constexpr int levels = 10;
        if (mesh::is_extraordinary(t, t.vertex(c))) {
            for (int level = levels; level > 1; --level) {
                breaks.push_back(start + std::ldexp(1.0, -level));
            }
        } else {
            breaks.push_back(start + 0.25);
        }
        breaks.push_back(start + 0.5);
        if (mesh::is_extraordinary(t, t.vertex(t.next(c)))) {
            for (int level = 2; level <= levels; ++level) {
                breaks.push_back(start + 1.0 - std::ldexp(1.0, -level));
            }
        } else {
            breaks.push_back(start + 0.75);
        }
        breaks.push_back(start + 1.0);
    }
    return breaks;
}

Cumulative::Cumulative(std::function<double(double)> f, std::vector<double> breaks)
    : f_(std::move(f)), breaks_(std::move(breaks)), sums_{0.0} {
    for (std::size_t k = 0; k + 1 < breaks_.size(); ++k) {
        sums_.push_back(sums_.back() + piece(breaks_[k], breaks_[k + 1]));
    }
}

double Cumulative::piece(double from, double to) const {
    // Gauss-Legendre, five points.
    static constexpr double x[] = {0.0, 0.5384693101056831, 0.9061798459386640};
    static constexpr double w[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    double sum = w[0] * f_(middle);
    for (int k = 1; k < 3; ++k) sum += w[k] * (f_(middle - half * x[k]) + f_(middle + half * x[k]));
    return sum * half;
}

double Cumulative::at(double t) const {
    const auto above = std::upper_bound(breaks_.begin(), breaks_.end() - 1, t);
    const auto k = std::size_t(std::max<std::ptrdiff_t>(above - breaks_.begin() - 1, 0));
    return sums_[k] + (t > breaks_[k] ? piece(breaks_[k], t) : 0.0);
}

double Cumulative::inverse(double value) const {
    const auto above = std::upper_bound(sums_.begin(), sums_.end() - 1, value);
    const auto k = std::size_t(std::max<std::ptrdiff_t>(above - sums_.begin() - 1, 0));
    double low = breaks_[k], high = breaks_[k + 1];
    if (value <= sums_[k]) return low;
    double t = low + (high - low) * std::min(1.0, (value - sums_[k]) / (sums_[k + 1] - sums_[k]));
    for (int step = 0; step < 30; ++step) {
        const double error = sums_[k] + piece(breaks_[k], t) - value;
        (error < 0.0 ? low : high) = t;
        if (std::abs(error) <= 1e-13 * total()) break;
        const double next = t - error / f_(t);
        t = next > low && next < high ? next : 0.5 * (low + high);
    }
    return t;
}

}  // namespace patchwright::grid
