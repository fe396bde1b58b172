#include "occ/foot/curve_search.h"

#include "occ/foot/descent_limits.h"

#include <patchwright/geom/nearest.h>

#include <GeomAdaptor_Curve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_Line.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <TColStd_Array1OfReal.hxx>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace patchwright::occ {

using geom::Vec3;

namespace {

/// Of curves that are evaluated by powers; the sum of higher ones loses digits.
constexpr int max_degree = 9;
/// Most halvings of an edge into chords: 16384 pieces.
constexpr int max_chord_depth = 14;
/// Arc by chord of an almost straight piece: an arc of 18 degrees (1 + angle^2 / 24).
constexpr double straight_ratio = 1.004;
/// Largest deviation of a piece by the largest one at five samples.
constexpr double sampling_margin = 1.5;
/// A step longer than this fraction of its chord may pass over a minimum.
constexpr double stride_fraction = 0.25;

Handle(Geom_Curve) untrimmed(const Handle(Geom_Curve) & curve) {
    const auto trimmed = Handle(Geom_TrimmedCurve)::DownCast(curve);
    return trimmed.IsNull() ? curve : untrimmed(trimmed->BasisCurve());
}

/// Of the polynomial between two neighbouring knots; -1 where the curve is none.
int degree_of(const Handle(Geom_Curve) & curve) {
    int degree = -1;
    if (const auto spline = Handle(Geom_BSplineCurve)::DownCast(curve); !spline.IsNull()) {
        if (!spline->IsRational()) degree = spline->Degree();
    } else if (const auto bezier = Handle(Geom_BezierCurve)::DownCast(curve); !bezier.IsNull()) {
        if (!bezier->IsRational()) degree = bezier->Degree();
    } else if (!Handle(Geom_Line)::DownCast(curve).IsNull()) {
        degree = 1;
    }
    return degree <= max_degree ? degree : -1;
}

/// Ends of the pieces that are smooth: continuously differentiable, or polynomials where the curve
/// has them. The kernel's own intervals of infinite smoothness leave out knots of high continuity.
std::vector<double> breaks_of(const ModelEdge& edge) {
    const GeomAdaptor_Curve adaptor(edge.curve, edge.first, edge.last);
    TColStd_Array1OfReal intervals(1, adaptor.NbIntervals(GeomAbs_C1) + 1);
    adaptor.Intervals(intervals, GeomAbs_C1);
    std::vector<double> breaks(intervals.begin(), intervals.end());
    const Handle(Geom_Curve) curve = untrimmed(edge.curve);
    const auto spline = Handle(Geom_BSplineCurve)::DownCast(curve);
    if (spline.IsNull() || degree_of(curve) < 0) return breaks;
    const double period = spline->IsPeriodic() ? spline->Period() : 0.0;
    const double least = 1e-9 * (edge.last - edge.first);
    for (int i = 1; i <= spline->NbKnots(); ++i) {
        double knot = spline->Knot(i);
        if (period > 0.0) knot += std::ceil((edge.first - knot) / period) * period;
        for (; knot < edge.last - least; knot += period) {
            const bool is_new = std::all_of(breaks.begin(), breaks.end(), [&](double other) {
                return std::abs(other - knot) > least;
            });
            if (is_new && knot > edge.first + least) breaks.push_back(knot);
            if (!(period > 0.0)) break;
        }
    }
    std::sort(breaks.begin(), breaks.end());
    return breaks;
}

}  // namespace

CurveSearch::CurveSearch(const std::vector<ModelEdge>& edges, const std::vector<int>& subset,
                         double deflection, double size)
    : edges_(&edges), size_(size) {
    for (const int edge : subset) add_edge(edge, deflection);
    std::vector<geom::Box3> boxes;
    boxes.reserve(chords_.size());
    for (const Chord& chord : chords_) {
        geom::Box3 box;
        box.add(chord.start);
        box.add(chord.end);
        box.min.array() -= chord.error;
        box.max.array() += chord.error;
        boxes.push_back(box);
    }
    tree_ = geom::Bvh(boxes);
    // Chords of a leaf, and of neighbouring leaves, lie together.
    std::vector<Chord> sorted;
    sorted.reserve(chords_.size());
    for (const std::int32_t number : tree_.sort_items())
        sorted.push_back(chords_[std::size_t(number)]);
    chords_ = std::move(sorted);
    sort_powers();
}

void CurveSearch::add_edge(int number, double deflection) {
    const ModelEdge& edge = (*edges_)[std::size_t(number)];
    const std::vector<double> breaks = breaks_of(edge);
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
        const double a = breaks[i], b = breaks[i + 1];
        split({edge.at(a), edge.at(b), a, b, 0.0, number, polynomial_on(edge, a, b)}, deflection,
              0);
    }
}

// Taylor's series around the middle: it ends with the degree.
CurveSearch::Polynomial CurveSearch::polynomial_on(const ModelEdge& edge, double from, double to) {
    Polynomial p;
    p.degree = degree_of(untrimmed(edge.curve));
    if (p.degree < 0) return p;
    const double half = 0.5 * (to - from);
    p.middle = 0.5 * (from + to);
    p.scale = 1.0 / half;
    p.first = std::int32_t(powers_.size());
    powers_.push_back(edge.at(p.middle));
    double factor = 1.0;
    for (int k = 1; k <= p.degree; ++k) {
        factor *= half / k;
        powers_.push_back(factor * vec(edge.curve->DN(p.middle, k)));
    }
    // Not trusted unseen: knots nearer to each other than the kernel distinguishes.
    for (const double x : {-1.0, -0.5, 0.5, 1.0}) {
        Vec3 at = Vec3::Zero();
        for (int k = p.degree; k >= 0; --k) at = x * at + powers_[std::size_t(p.first + k)];
        if (!((at - edge.at(p.middle + x * half)).norm() <= rounding_rel * size_)) return {};
    }
    return p;
}

// As the chords lie, so that they are found together.
void CurveSearch::sort_powers() {
    std::vector<Vec3> sorted;
    sorted.reserve(powers_.size());
    std::vector<std::int32_t> place(powers_.size(), -1);
    for (Chord& chord : chords_) {
        if (chord.polynomial.degree < 0) continue;
        std::int32_t& now = place[std::size_t(chord.polynomial.first)];
        if (now < 0) {
            now = std::int32_t(sorted.size());
            const auto begin = powers_.begin() + chord.polynomial.first;
            sorted.insert(sorted.end(), begin, begin + chord.polynomial.degree + 1);
        }
        chord.polynomial.first = now;
    }
    powers_ = std::move(sorted);
}

void CurveSearch::split(Chord chord, double deflection, int depth) {
    const ModelEdge& edge = (*edges_)[std::size_t(chord.edge)];
    double off = 0.0, arc = 0.0;
    Vec3 last = chord.start, middle = chord.start;
    for (const double s : {0.2, 0.4, 0.5, 0.6, 0.8, 1.0}) {
        const Vec3 p = edge.at(chord.t0 + s * (chord.t1 - chord.t0));
        const double at = chord_parameter(chord, p);
        off = std::max(off, (chord.start + at * (chord.end - chord.start) - p).norm());
        arc += (p - last).norm();
        last = p;
        if (s == 0.5) middle = p;
    }
    // The arc's excess bounds the turning: about angle^2 / 24 for an arc of circle.
    const bool straight =
        arc <= (chord.end - chord.start).norm() * straight_ratio + rounding_rel * size_;
    if ((off <= deflection && straight) || depth >= max_chord_depth) {
        chord.error = sampling_margin * off + edge.tolerance + rounding_rel * size_;
        chords_.push_back(chord);
        return;
    }
    const double t = 0.5 * (chord.t0 + chord.t1);
    split({chord.start, middle, chord.t0, t, 0.0, chord.edge, chord.polynomial}, deflection,
          depth + 1);
    split({middle, chord.end, t, chord.t1, 0.0, chord.edge, chord.polynomial}, deflection,
          depth + 1);
}

double CurveSearch::chord_parameter(const Chord& chord, const Vec3& query) {
    return geom::nearest_on_segment(query, chord.start, chord.end).share;
}

CurveHit CurveSearch::nearest_on(const Chord& chord, const Vec3& query, double s) const {
    CurveHit best = descend(chord, query, s);
    const double length = (chord.end - chord.start).squaredNorm();
    // Where the piece curves more than a circle around the query it may hold several minima.
    if (best.distance * 8.0 * chord.error < 0.5 * length) return best;
    for (const double other : {0.2, 0.5, 0.8}) {
        const CurveHit hit = descend(chord, query, other);
        if (hit.distance < best.distance) best = hit;
    }
    return best;
}

inline void CurveSearch::evaluate(const Chord& chord, double t, Vec3& p, Vec3& d, Vec3& dd) const {
    const Polynomial& powers = chord.polynomial;
    if (powers.degree >= 0) {
        // Horner's rule; the second derivative comes out halved.
        const double x = (t - powers.middle) * powers.scale;
        const Vec3* c = &powers_[std::size_t(powers.first)];
        p = c[powers.degree];
        d = dd = Vec3::Zero();
        for (int k = powers.degree - 1; k >= 0; --k) {
            dd = x * dd + d;
            d = x * d + p;
            p = x * p + c[k];
        }
        d *= powers.scale;
        dd *= 2.0 * powers.scale * powers.scale;
        return;
    }
    gp_Pnt gp;
    gp_Vec gd, gdd;
    (*edges_)[std::size_t(chord.edge)].curve->D2(t, gp, gd, gdd);
    p = vec(gp);
    d = vec(gd);
    dd = vec(gdd);
}

CurveHit CurveSearch::descend(const Chord& chord, const Vec3& query, double s) const {
    constexpr int max_steps = 30, max_halvings = 12;
    const double stride = stride_fraction * (chord.end - chord.start).norm() + 1e-9 * size_;
    Vec3 p, d, dd;
    double t = chord.t0 + s * (chord.t1 - chord.t0);
    evaluate(chord, t, p, d, dd);
    for (int i = 0; i < max_steps; ++i) {
        const Vec3 r = p - query;
        const double slope = r.dot(d), metric = d.squaredNorm();
        double second = metric + r.dot(dd);
        const bool newton = second > definite_fraction * metric;
        if (!newton) second = metric;
        if (!(second > 0.0)) break;
        const double step = std::clamp(t - slope / second, chord.t0, chord.t1) - t;
        const double length = std::abs(step) * std::sqrt(metric);
        if (!(length > no_step_rel * size_)) break;
        double fraction = std::min(1.0, (newton ? 2.0 : 1.0) * stride / length);
        // Newton's last step gains less than rounding shows. Beside a point without a tangent a
        // long way in the parameter looks short.
        const bool last = newton && length < final_step_rel * size_ && fraction == 1.0;
        const double rounding = last ? no_step_rel * size_ : 0.0;
        const double before = r.squaredNorm() + rounding * (2.0 * r.norm() + rounding);
        Vec3 next, next_d, next_dd;
        for (int k = 0; k < max_halvings; ++k, fraction *= 0.5) {
            evaluate(chord, t + fraction * step, next, next_d, next_dd);
            if ((next - query).squaredNorm() <= before) break;
        }
        if ((next - query).squaredNorm() > before) break;
        t += fraction * step;
        p = next;
        d = next_d;
        dd = next_dd;
        if (last) break;
    }
    return {chord.edge, t, p, (p - query).norm()};
}

}  // namespace patchwright::occ
