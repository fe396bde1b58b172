#include "cage/sections/bend.h"
#include "cage/sections/wing_finder.h"
#include "geom/polyline.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Along a curve, where its distances and heights are taken.
constexpr int samples = 8;
// Of chord times thickness of the section nearby: triangles in the plane of an end that cover more
// are a lid, fewer the outermost points of a rounded tip.
constexpr double least_lid = 0.3;
// How many thicknesses inward a ridge may reach that runs round a tip.
constexpr double longest_ridge_reach = 3.0;
// Of the chord, between the ends of a ridge: shorter ones are edges of a blunt trailing edge.
constexpr double shortest_ridge = 0.5;
// Where sections are taken to know how large the wing is at an end, inside of a lid or of a tip's
// rounding: of the chord, as ends may be short winglets, and at most of the span.
constexpr double beside_lid_chords = 0.1, beside_tip_chords = 0.5, beside_end_rel = 0.1;
// In thicknesses: a curve around the body this near to the end is where the tip begins.
constexpr double reach_of_tip = 1.5;
// In thicknesses: farther from the end no tip begins.
constexpr double farthest_ring = 4.0;
// Of the chord: shorter curves in a section's plane are flaws, not lines around the body.
constexpr double shortest_line_around = 0.3;
// Of the way around a section: curves in its plane that leave it by more are a fin's.
constexpr double along_section_share = 0.1;
// Of the span: shorter sharp lines are flaws that no line of the cage is made for.
constexpr double shortest_sharp_rel = 0.01;
// Of the span: lines that stay within this of an end belong to it.
constexpr double at_end_rel = 2e-3;

/// How the beginning of a tip is looked for: at growing shares of the thickness from the end, until
/// a section is about as thick as those farther in. A ridge needs a ring where the tip has turned
/// half of its way, a rounded tip one where it starts to turn.
struct TipSearch {
    double first_share, growth, thick_enough;
};
constexpr TipSearch rounded_tip{0.3, 1.25, 0.85}, sharp_tip{0.1, 1.1, 0.6};

}  // namespace

bool WingFinder::classify(WingEnd& end) {
    const geom::SurfaceMesh& mesh = *wing_.slicer.body().mesh;
    const auto at_end = [&](int v) {
        return std::abs(wing_.slicer.height(v) - end.extreme) < flat_rel * wing_.span;
    };
    const Vec3 direction = wing_.slicer.spine().direction(end.extreme);
    double lid = 0.0;
    for (const int t : wing_.slicer.body().triangles) {
        const auto& c = mesh.triangles[std::size_t(t)];
        if (!at_end(c[0]) || !at_end(c[1]) || !at_end(c[2])) continue;
        const Vec3 a = mesh.points.row(c[0]), b = mesh.points.row(c[1]), d = mesh.points.row(c[2]);
        lid += 0.5 * std::abs((b - a).cross(d - a).dot(direction));
    }
    end.ring = end.extreme - end.outward * inside_rel * wing_.span;
    const SectionResult beside =
        section_beside(end, beside_lid_chords * known_near(end.extreme)->chord);
    if (!beside.section) return refuse(fmt::format("the section beside an end has {}", beside.why));
    const SectionResult near = section_beside(end, beside_tip_chords * beside.section->chord);
    if (!near.section) return refuse(fmt::format("the section near an end has {}", near.why));
    if (lid > least_lid * beside.section->chord * beside.section->thickness) {
        end.kind = EndKind::Lid;
        return true;
    }
    for (SectionLoop& rim : rims(wing_.slicer.body())) {
        for (const Vec3& p : rim.points)
            if (std::abs(wing_.slicer.spine().height(p) - end.extreme) < flat_rel * wing_.span)
                end.kind = EndKind::Open;
        if (end.kind != EndKind::Open) continue;
        end.rim = std::move(rim);
        if (end.outward > 0.0) end.rim.reverse();
        return true;
    }
    find_ridge(end, *near.section);
    if (end.kind == EndKind::Ridge) {  // near the nose it is the nose's line
        wing_.nose_line = true;
        wing_.lines.nose.insert(end.ridge);
    }
    return place_ring(end, *near.section);
}

SectionResult WingFinder::section_beside(const WingEnd& end, double inward) const {
    return section_at(end.extreme - end.outward * std::min(beside_end_rel * wing_.span, inward));
}

void WingFinder::find_ridge(WingEnd& end, const WingSection& near) const {
    if (wing_.blunt) return;
    const auto& curves = reference_.features().curves;
    for (int i = 0; i < int(curves.size()); ++i) {
        const geom::FeatureCurve& curve = curves[std::size_t(i)];
        if (curve.kind != geom::FeatureKind::Sharp || curve.closed ||
            wing_.lines.tail.contains(i) || wing_.lines.nose.contains(i))
            continue;
        double nearest = wing_.span, farthest = 0.0;
        poll_();
        for (int k = 0; k <= 2 * samples; ++k) {
            const Vec3 p = reference_.point_on_curve(i, curve.length * k / (2.0 * samples)).point;
            const double way = std::abs(end.extreme - wing_.slicer.spine().height(p));
            nearest = std::min(nearest, way);
            farthest = std::max(farthest, way);
        }
        if (nearest > in_plane_rel * wing_.span || farthest > longest_ridge_reach * near.thickness)
            continue;
        double start = wing_.span, stop = wing_.span;
        for (const int tail : wing_.lines.tail) {
            start = std::min(start, reference_.nearest_on_curve(tail, curve.start).distance);
            stop = std::min(stop, reference_.nearest_on_curve(tail, curve.end).distance);
        }
        if (std::min(start, stop) > flat_rel * wing_.span ||
            (curve.start - curve.end).norm() < shortest_ridge * near.chord)
            continue;
        if (end.kind == EndKind::Ridge) {  // two of them are the border of a face
            end.kind = EndKind::Rounded;
            return;
        }
        end.kind = EndKind::Ridge;
        end.ridge = i;
        end.starts_at_tail = start < stop;
    }
}

bool WingFinder::place_ring(WingEnd& end, const WingSection& near) {
    // Where a line of the model runs around the body near the end, the tip starts there.
    const bool ridge = end.kind == EndKind::Ridge;
    const TipSearch& tip = ridge ? sharp_tip : rounded_tip;
    const double thickness = near.thickness, reach = ridge ? 0.0 : reach_of_tip * thickness;
    std::optional<double> best;
    for (const double height : lines_around())
        if (std::abs(end.extreme - height) < reach && std::abs(end.extreme - height) > 0.0)
            if (!best || std::abs(end.extreme - height) > std::abs(end.extreme - *best))
                best = height;
    for (double share = tip.first_share; !best && share < farthest_ring; share *= tip.growth) {
        const double height = end.extreme - end.outward * share * thickness;
        const auto section = section_at(height).section;
        if (section && !section->faded && section->thickness > tip.thick_enough * thickness)
            best = height;
    }
    if (!best) return refuse("no section is found where its tip begins");
    // Beside a tip whose borders meet in the trailing edge's end, it ends where the tip starts.
    for (const int curve : wing_.lines.tail) {
        const auto [low, high] = range_of(curve);
        const double tail_end = end.outward > 0.0 ? high : low;
        if (wing_.blunt || std::abs(tail_end - *best) > reach_of_tip * thickness) continue;
        best = end.outward * std::min(end.outward * *best, end.outward * tail_end);
    }
    end.ring = *best - end.outward * inside_rel * wing_.span;
    return true;
}

bool WingFinder::on_body(int curve) const {
    const auto& features = wing_.slicer.body().mesh->features;
    return std::any_of(features.begin(), features.end(), [&](const geom::FeatureSide& f) {
        return f.curve == curve && wing_.slicer.holds(f.v0);
    });
}

std::vector<double> WingFinder::lines_around() const {
    const auto& curves = reference_.features().curves;
    std::vector<double> heights;
    for (std::size_t i = 0; i < curves.size(); ++i) {
        const auto [low, high] = range_of(int(i));
        if (high - low > in_plane_rel * wing_.span || !on_body(int(i))) continue;
        const double height = 0.5 * (low + high);
        const auto section = section_at(height).section;
        if (section && curves[i].length > shortest_line_around * section->chord)
            heights.push_back(height);
    }
    std::sort(heights.begin(), heights.end());
    return heights;
}

std::pair<double, double> WingFinder::range_of(int curve) const {
    const double length = reference_.features().curves[std::size_t(curve)].length;
    poll_();
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int k = 0; k <= samples; ++k) {
        const double height = wing_.slicer.spine().height(
            reference_.point_on_curve(curve, length * k / double(samples)).point);
        low = std::min(low, height);
        high = std::max(high, height);
    }
    return {low, high};
}

bool WingFinder::at_an_end(std::pair<double, double> range) const {
    return std::any_of(wing_.ends.begin(), wing_.ends.end(), [&](const WingEnd& end) {
        return std::max(std::abs(range.first - end.extreme), std::abs(range.second - end.extreme)) <
               at_end_rel * wing_.span;
    });
}

bool WingFinder::runs_along_section(int curve, double height) const {
    const double length = reference_.features().curves[std::size_t(curve)].length;
    const auto along = [&](const SectionLoop& loop) {
        for (int k = 0; k <= samples; ++k) {
            poll_();
            const Vec3 p = reference_.point_on_curve(curve, length * k / double(samples)).point;
            if (geom::distance_to(loop.points, p) > along_section_share * loop.length())
                return false;
        }
        return true;
    };
    // Beside the curve, where sections do not touch a bend.
    for (const double side : {-distinct_rel, distinct_rel}) {
        const auto loops = wing_.slicer.cut(height + side * wing_.span);
        if (std::any_of(loops.begin(), loops.end(), along)) return true;
    }
    return false;
}

void WingFinder::find_lines_around() {
    const auto& curves = reference_.features().curves;
    for (int i = 0; i < int(curves.size()); ++i) {
        const geom::FeatureCurve& curve = curves[std::size_t(i)];
        if (!needs_crease(curve, wing_.span, options_.tolerance_mm) ||
            curve.length < shortest_sharp_rel * wing_.span || !on_body(i))
            continue;
        const auto range = range_of(i);
        if (range.second - range.first < in_plane_rel * wing_.span && !at_an_end(range) &&
            runs_along_section(i, 0.5 * (range.first + range.second)))
            wing_.lines.around.insert(i);
    }
}

bool WingFinder::all_lines_known() {
    const auto& curves = reference_.features().curves;
    for (int i = 0; i < int(curves.size()); ++i) {
        const geom::FeatureCurve& curve = curves[std::size_t(i)];
        if (curve.kind != geom::FeatureKind::Sharp || wing_.lines.tail.contains(i) ||
            wing_.lines.nose.contains(i) || curve.length < shortest_sharp_rel * wing_.span ||
            !on_body(i))
            continue;
        const auto [low, high] = range_of(i);
        // Sections cross the others, or they are a tip's.
        bool known = high - low > in_plane_rel * wing_.span || wing_.lines.around.contains(i) ||
                     at_an_end({low, high});
        for (const WingEnd& end : wing_.ends) known = known || end.ridge == i;
        if (!known)
            return refuse(fmt::format("a sharp line runs across {}", percent(0.5 * (low + high))));
    }
    return true;
}

void WingFinder::find_span_of_lines() {
    for (const auto* curves : {&wing_.lines.tail, &wing_.lines.nose}) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const int curve : *curves) {
            const auto range = range_of(curve);
            low = std::min(low, range.first);
            high = std::max(high, range.second);
        }
        if (low > high) continue;
        line_ends_.push_back(low + inside_rel * wing_.span);
        line_ends_.push_back(high - inside_rel * wing_.span);
        for (const int curve : *curves) {
            const geom::FeatureCurve& c = reference_.features().curves[std::size_t(curve)];
            for (const int corner : {c.start_corner, c.end_corner}) {
                if (corner < 0) continue;
                const double height = wing_.slicer.spine().height(
                    reference_.features().corners[std::size_t(corner)].point);
                if (height > low && height < high) line_ends_.push_back(height);
            }
        }
    }
    std::sort(line_ends_.begin(), line_ends_.end());
}

}  // namespace patchwright::cage
