#include "curve_search.h"

#include <GeomAdaptor_Curve.hxx>
#include <TColStd_Array1OfReal.hxx>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace patchwright::occ {

using geom::Vec3;

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
}

void CurveSearch::add_edge(int number, double deflection) {
    const ModelEdge& edge = (*edges_)[std::size_t(number)];
    const GeomAdaptor_Curve adaptor(edge.curve, edge.first, edge.last);
    TColStd_Array1OfReal breaks(1, adaptor.NbIntervals(GeomAbs_C1) + 1);
    adaptor.Intervals(breaks, GeomAbs_C1);
    for (int i = breaks.Lower(); i < breaks.Upper(); ++i) {
        const double a = breaks(i), b = breaks(i + 1);
        split({edge.at(a), edge.at(b), a, b, 0.0, number}, deflection, 0);
    }
}

void CurveSearch::split(Chord chord, double deflection, int depth) {
    constexpr int max_depth = 14;
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
    const bool straight = arc <= (chord.end - chord.start).norm() * 1.004 + 1e-12 * size_;
    if ((off <= deflection && straight) || depth >= max_depth) {
        chord.error = 1.5 * off + edge.tolerance + 1e-12 * size_;
        chords_.push_back(chord);
        return;
    }
    const double t = 0.5 * (chord.t0 + chord.t1);
    split({chord.start, middle, chord.t0, t, 0.0, chord.edge}, deflection, depth + 1);
    split({middle, chord.end, t, chord.t1, 0.0, chord.edge}, deflection, depth + 1);
}

double CurveSearch::chord_parameter(const Chord& chord, const Vec3& query) {
    const Vec3 along = chord.end - chord.start;
    const double length = along.squaredNorm();
    if (!(length > 0.0)) return 0.0;
    return std::clamp((query - chord.start).dot(along) / length, 0.0, 1.0);
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

CurveHit CurveSearch::descend(const Chord& chord, const Vec3& query, double s) const {
    constexpr int max_steps = 30, max_halvings = 12;
    const Handle(Geom_Curve)& curve = (*edges_)[std::size_t(chord.edge)].curve;
    const double stride = 0.25 * (chord.end - chord.start).norm() + 1e-9 * size_;
    const auto evaluate = [&](double t, Vec3& p, Vec3& d, Vec3& dd) {
        gp_Pnt gp;
        gp_Vec gd, gdd;
        curve->D2(t, gp, gd, gdd);
        p = vec(gp);
        d = vec(gd);
        dd = vec(gdd);
    };
    Vec3 p, d, dd;
    double t = chord.t0 + s * (chord.t1 - chord.t0);
    evaluate(t, p, d, dd);
    for (int i = 0; i < max_steps; ++i) {
        const Vec3 r = p - query;
        const double slope = r.dot(d), metric = d.squaredNorm();
        double second = metric + r.dot(dd);
        const bool newton = second > 1e-9 * metric;
        if (!newton) second = metric;
        if (!(second > 0.0)) break;
        const double step = std::clamp(t - slope / second, chord.t0, chord.t1) - t;
        const double length = std::abs(step) * std::sqrt(metric);
        if (!(length > 1e-13 * size_)) break;
        double fraction = std::min(1.0, (newton ? 2.0 : 1.0) * stride / length);
        const double before = r.squaredNorm();
        Vec3 next, next_d, next_dd;
        for (int k = 0; k < max_halvings; ++k, fraction *= 0.5) {
            evaluate(t + fraction * step, next, next_d, next_dd);
            if ((next - query).squaredNorm() <= before) break;
        }
        if ((next - query).squaredNorm() > before) break;
        t += fraction * step;
        p = next;
        d = next_d;
        dd = next_dd;
        if (newton && length < 1e-8 * size_ && fraction == 1.0) break;
    }
    return {chord.edge, t, p, (p - query).norm()};
}

}  // namespace patchwright::occ
