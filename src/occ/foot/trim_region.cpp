#include "occ/foot/trim_region.h"

#include <BRep_Tool.hxx>
#include <Geom2dAdaptor_Curve.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Iterator.hxx>

#include <algorithm>
#include <cmath>
#include <limits>

namespace patchwright::occ {

namespace {

constexpr double chord_bulge = 2e-3;   // of the region's size: chords finer than this gain nothing
constexpr double exact_bulge = 1e-13;  // of the region's size: curve and chord are the same
constexpr double side_tolerance = 1e-8;  // of the region's size: a p-curve runs along a side
constexpr int max_trim_depth = 12;
constexpr int max_trim_halvings = 40;

}  // namespace

TrimRegion::TrimRegion(const TopoDS_Face& face) {
    const TopoDS_Face forward = TopoDS::Face(face.Oriented(TopAbs_FORWARD));
    std::vector<std::vector<EdgeRun>> wires;
    for (TopoDS_Iterator it(forward); it.More(); it.Next()) {
        if (it.Value().ShapeType() == TopAbs_WIRE) wires.push_back(runs_of(it.Value(), forward));
    }
    std::erase_if(wires, [](const auto& runs) { return runs.empty(); });
    for (const auto& runs : wires) {
        for (const EdgeRun& run : runs) add_curve(run);
        close_gaps(runs);
    }
    measure();
    rectangle_ = wires.size() == 1 && all_on_rectangle();
    make_bands();
}

// Widens the rectangle roughly, so that chords can be made fine relative to the region's size.
std::vector<TrimRegion::EdgeRun> TrimRegion::runs_of(const TopoDS_Shape& wire,
                                                     const TopoDS_Face& face) {
    std::vector<EdgeRun> runs;
    for (TopoDS_Iterator it(wire); it.More(); it.Next()) {
        const TopoDS_Edge& edge = TopoDS::Edge(it.Value());
        const bool reversed = edge.Orientation() == TopAbs_REVERSED;
        if (!reversed && edge.Orientation() != TopAbs_FORWARD) continue;
        EdgeRun run;
        run.curve = BRep_Tool::CurveOnSurface(edge, face, run.first, run.last);
        if (run.curve.IsNull()) continue;
        run.start = vec(run.curve->Value(reversed ? run.last : run.first));
        run.end = vec(run.curve->Value(reversed ? run.first : run.last));
        constexpr int samples = 8;
        for (int i = 0; i <= samples; ++i) {
            const Vec2 p = vec(run.curve->Value(run.first + (run.last - run.first) * i / samples));
            low_ = low_.cwiseMin(p);
            high_ = high_.cwiseMax(p);
        }
        runs.push_back(run);
    }
    return runs;
}

void TrimRegion::add_curve(const EdgeRun& run) {
    const auto index = std::int32_t(curves_.size());
    curves_.push_back(run.curve);
    const Geom2dAdaptor_Curve adaptor(run.curve, run.first, run.last);
    TColStd_Array1OfReal breaks(1, adaptor.NbIntervals(GeomAbs_C1) + 1);
    adaptor.Intervals(breaks, GeomAbs_C1);
    const auto at = [&](double t) { return vec(run.curve->Value(t)); };
    for (int i = breaks.Lower(); i < breaks.Upper(); ++i) {
        const double a = breaks(i), b = breaks(i + 1), middle = 0.5 * (a + b);
        split({at(a), at(middle), Vec2::Zero(), a, middle, index}, 0);
        split({at(middle), at(b), Vec2::Zero(), middle, b, index}, 0);
    }
}

void TrimRegion::split(Chord chord, int depth) {
    const Handle(Geom2d_Curve)& curve = curves_[std::size_t(chord.curve)];
    Vec2 bulge = Vec2::Zero(), middle = Vec2::Zero();
    for (const double s : {0.25, 0.5, 0.75}) {
        const Vec2 p = vec(curve->Value(chord.t0 + s * (chord.t1 - chord.t0)));
        bulge = bulge.cwiseMax((p - ((1 - s) * chord.start + s * chord.end)).cwiseAbs());
        if (s == 0.5) middle = p;
    }
    const Vec2 size = (high_ - low_).cwiseMax(1e-12);
    const bool fine = (bulge.array() <= chord_bulge * size.array()).all();
    const bool straight = (bulge.array() <= exact_bulge * size.array()).all();
    if (straight || (fine && depth > 0) || depth >= max_trim_depth) {
        // Three points see the bulge of a cubic to within a few per cent; doubled to be safe.
        chord.bulge = straight ? Vec2(Vec2::Zero()) : Vec2(2.0 * bulge);
        chords_.push_back(chord);
        return;
    }
    const double t = 0.5 * (chord.t0 + chord.t1);
    split({chord.start, middle, Vec2::Zero(), chord.t0, t, chord.curve}, depth + 1);
    split({middle, chord.end, Vec2::Zero(), t, chord.t1, chord.curve}, depth + 1);
}

void TrimRegion::close_gaps(const std::vector<EdgeRun>& runs) {
    // Wires from files need not list their edges in order: each end is joined to the nearest start.
    std::vector<bool> taken(runs.size(), false);
    for (const EdgeRun& run : runs) {
        std::size_t next = 0;
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < runs.size(); ++i) {
            const double distance = (runs[i].start - run.end).norm();
            if (!taken[i] && distance < nearest) {
                nearest = distance;
                next = i;
            }
        }
        taken[next] = true;
        if (nearest > 0.0)
            chords_.push_back({run.end, runs[next].start, Vec2::Zero(), 0.0, 0.0, -1});
    }
}

void TrimRegion::measure() {
    if (chords_.empty()) {
        low_ = high_ = Vec2::Zero();
        return;
    }
    low_ = high_ = chords_.front().start;
    for (const Chord& c : chords_) {
        low_ = low_.cwiseMin(c.start.cwiseMin(c.end));
        high_ = high_.cwiseMax(c.start.cwiseMax(c.end));
    }
    // The curve may reach beyond its chords, but not beyond the sides it merely touches by
    // rounding.
    const Vec2 from = low_, to = high_, size = to - from;
    for (const Chord& c : chords_) {
        const Vec2 below = c.start.cwiseMin(c.end) - c.bulge,
                   above = c.start.cwiseMax(c.end) + c.bulge;
        for (int i = 0; i < 2; ++i) {
            if (c.bulge[i] <= side_tolerance * size[i]) continue;
            low_[i] = std::min(low_[i], below[i]);
            high_[i] = std::max(high_[i], above[i]);
        }
    }
}

bool TrimRegion::all_on_rectangle() const {
    const Vec2 size = high_ - low_;
    if ((size.array() <= 0.0).any()) return false;
    return std::all_of(chords_.begin(), chords_.end(), [&](const Chord& c) {
        for (int i = 0; i < 2; ++i) {
            const double tolerance = side_tolerance * size[i];
            if (c.bulge[i] > tolerance) continue;
            for (const double side : {low_[i], high_[i]}) {
                if (std::abs(c.start[i] - side) <= tolerance &&
                    std::abs(c.end[i] - side) <= tolerance)
                    return true;
            }
        }
        return false;
    });
}

void TrimRegion::make_bands() {
    const auto count = std::int32_t(std::clamp<std::size_t>(2 * chords_.size(), 8, 2048));
    const double height = std::max(high_.y() - low_.y(), 1e-300);
    const auto band_of = [&](double v) {
        return std::clamp(std::int32_t((v - low_.y()) / height * count), 0, count - 1);
    };
    const auto span = [&](const Chord& c) {
        return std::pair(band_of(std::min(c.start.y(), c.end.y()) - c.bulge.y()),
                         band_of(std::max(c.start.y(), c.end.y()) + c.bulge.y()));
    };
    band_start_.assign(std::size_t(count) + 1, 0);
    for (const Chord& c : chords_) {
        const auto [a, b] = span(c);
        for (auto i = a; i <= b; ++i) ++band_start_[std::size_t(i) + 1];
    }
    for (std::size_t i = 1; i < band_start_.size(); ++i) band_start_[i] += band_start_[i - 1];
    band_chords_.resize(std::size_t(band_start_.back()));
    std::vector<std::int32_t> fill(band_start_.begin(), band_start_.end() - 1);
    for (std::size_t k = 0; k < chords_.size(); ++k) {
        const auto [a, b] = span(chords_[k]);
        for (auto i = a; i <= b; ++i)
            band_chords_[std::size_t(fill[std::size_t(i)]++)] = std::int32_t(k);
    }
}

bool TrimRegion::crosses(const Chord& c, const Vec2& uv, int depth) const {
    const double v = uv.y();
    const bool straddles = (c.start.y() > v) != (c.end.y() > v);
    if (v < std::min(c.start.y(), c.end.y()) - c.bulge.y() ||
        v > std::max(c.start.y(), c.end.y()) + c.bulge.y() ||
        uv.x() > std::max(c.start.x(), c.end.x()) + c.bulge.x())
        return false;
    if (uv.x() < std::min(c.start.x(), c.end.x()) - c.bulge.x()) return straddles;
    const Vec2 size = high_ - low_;
    const Eigen::Array2d exact = exact_bulge * size.array();
    // Along u or v, however unevenly run through: only where its ends are matters.
    const bool along_axis = ((c.end - c.start).array().abs() + c.bulge.array() <= exact).any();
    if (c.curve < 0 || depth >= max_trim_halvings || along_axis ||
        (c.bulge.array() <= exact).all()) {
        if (!straddles) return false;
        const double s = (v - c.start.y()) / (c.end.y() - c.start.y());
        return uv.x() < c.start.x() + s * (c.end.x() - c.start.x());
    }
    const double t = 0.5 * (c.t0 + c.t1);
    const Vec2 middle = vec(curves_[std::size_t(c.curve)]->Value(t));
    // Halving a smooth curve quarters its bulge; a third allows for uneven curvature.
    const Vec2 bulge = c.bulge / 3.0;
    return crosses({c.start, middle, bulge, c.t0, t, c.curve}, uv, depth + 1) !=
           crosses({middle, c.end, bulge, t, c.t1, c.curve}, uv, depth + 1);
}

bool TrimRegion::contains(const Vec2& uv) const {
    if ((uv.array() < low_.array()).any() || (uv.array() > high_.array()).any()) return false;
    if (rectangle_) return true;
    const auto bands = std::int32_t(band_start_.size()) - 1;
    const double height = std::max(high_.y() - low_.y(), 1e-300);
    const auto band =
        std::size_t(std::clamp(std::int32_t((uv.y() - low_.y()) / height * bands), 0, bands - 1));
    bool inside = false;
    for (auto i = band_start_[band]; i < band_start_[band + 1]; ++i)
        inside ^= crosses(chords_[std::size_t(band_chords_[std::size_t(i)])], uv, 0);
    return inside;
}

}  // namespace patchwright::occ
