#include "cage/sections/wing_section.h"

#include "geom/angle.h"
#include "geom/polyline.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Of the chord: two edges nearer than this are one blunt trailing edge.
constexpr double widest_trailing_edge = 0.06;
// Of the chord: as wide as a trailing edge may become where its curves are known, as at the root of
// a blade.
constexpr double widest_followed = 0.25;
// Of the chord; usual sections are up to 0.24 thick, those near the root of a blade more. A body
// with thicker ones only is no wing.
constexpr double thickest = 0.45;
// Between both sides of a trailing edge: 57 degrees, where usual ones have up to 20.
constexpr double widest_wedge_rad = 1.0;
// Of the way around: how far from a trailing edge the directions of both sides are taken.
constexpr double wedge_reach = 0.05;
// Added to the wedge's angle of a sharp edge, so that of two edges that make one blunt trailing
// edge with parallel sides the pair is taken; 0.06 degrees.
constexpr double prefers_pairs_rad = 1e-3;
// Of the chord: sharp lines this near to the nose are the leading edge.
constexpr double nose_zone = 0.04;
// Of the chord: a line that crosses this near to the trailing edge is a flaw of its end.
constexpr double across_tail = 1e-3;
// Fewer points are a section of a few triangles only, which shows no form.
constexpr int fewest_points = 8;
// Where the thickness is measured, along both sides.
constexpr int thickness_samples = 20;
// Of the chord: half of the width that a sharp trailing edge gets when it is to be blunt.
constexpr double half_width_opened = 5e-4;

/// Crossings of sharp curves and of those given. Sides of triangles keep the curve of a whole edge,
/// which may be sharp on a part of it only.
std::vector<Crossing> crossings_of(const SectionLoop& loop, const geom::ModelSurface& reference,
                                   const std::set<int>& also = {}) {
    constexpr double on_curve_rel = 2e-3;  // of the way around; far more than the deflection
    const double on_curve = on_curve_rel * loop.length();
    std::vector<Crossing> crossings;
    for (const Crossing& c : loop.crossings)
        if ((also.contains(c.curve) ||
             reference.features().curves[std::size_t(c.curve)].kind == geom::FeatureKind::Sharp) &&
            reference.nearest_on_curve(c.curve, loop.points[std::size_t(c.point)]).distance <
                on_curve)
            crossings.push_back(c);
    return crossings;
}

/// From point `from` of the loop a way along it, forward or backward.
Vec3 walk(const SectionLoop& loop, int from, double way, int direction) {
    const int count = int(loop.points.size());
    int i = from;
    for (int n = 0; n < count; ++n) {
        const int next = (i + direction + count) % count;
        const Vec3 step = loop.points[std::size_t(next)] - loop.points[std::size_t(i)];
        if (way <= step.norm() && way > 0.0)
            return loop.points[std::size_t(i)] + way / step.norm() * step;
        way -= step.norm();
        i = next;
    }
    return loop.points[std::size_t(i)];
}

/// Length from one point of a loop to another, the way the loop runs.
double way_between(const SectionLoop& loop, int from, int to) {
    const int count = int(loop.points.size());
    double way = 0.0;
    for (int i = from; i != to; i = (i + 1) % count)
        way += (loop.points[std::size_t((i + 1) % count)] - loop.points[std::size_t(i)]).norm();
    return way;
}

/// First and last point of the trailing edge, in the loop's direction: equal when it is sharp.
struct Tail {
    int first, last;
};

Vec3 center_of(const SectionLoop& loop) {
    Vec3 sum = Vec3::Zero();
    double length = 0.0;
    for (std::size_t i = 0; i < loop.points.size(); ++i) {
        const Vec3& a = loop.points[i];
        const Vec3& b = loop.points[(i + 1) % loop.points.size()];
        sum += 0.5 * (b - a).norm() * (a + b);
        length += (b - a).norm();
    }
    return sum / length;
}

int nearest_point(const SectionLoop& loop, const Vec3& p) {
    int best = 0;
    for (int i = 1; i < int(loop.points.size()); ++i)
        if ((loop.points[std::size_t(i)] - p).norm() < (loop.points[std::size_t(best)] - p).norm())
            best = i;
    return best;
}

/// Where the trailing edge of a section nearby would be on this one.
Tail tail_like(const SectionLoop& loop, const WingSection& like) {
    const double scale = loop.length() / (like.length(0) + like.length(1));
    const Vec3 center = center_of(loop);
    const auto place = [&](const Vec3& p) {
        return nearest_point(loop, center + scale * (p - like.center));
    };
    if (!like.blunt) {
        const int at = place(like.trailing_edge());
        return {at, at};
    }
    const int count = int(loop.points.size());
    Tail tail{place(like.sides[1].back()), place(like.sides[0].front())};
    if (tail.first == tail.last) tail.last = (tail.first + 1) % count;
    return tail;
}

/// Where the trailing edge of a section is that one or two of its curves cross.
Tail tail_at(const SectionLoop& loop, const std::vector<int>& edges) {
    Tail tail{edges.front(), edges.back()};
    if (way_between(loop, tail.first, tail.last) > way_between(loop, tail.last, tail.first))
        std::swap(tail.first, tail.last);
    return tail;
}

/// From the trailing edge all the way around to it.
std::vector<Vec3> without_tail(const SectionLoop& loop, const Tail& tail) {
    const int count = int(loop.points.size());
    std::vector<Vec3> around(loop.points);
    std::rotate(around.begin(), around.begin() + tail.last, around.end());
    if (tail.first != tail.last) {
        around.resize(std::size_t((tail.first - tail.last + count) % count + 1));
    } else {
        around.push_back(around.front());
    }
    return around;
}

/// Thickness and nose radius.
void measure_form(WingSection& section, const geom::ModelSurface& reference) {
    for (int i = 1; i < thickness_samples; ++i) {
        const double share = i / double(thickness_samples);
        section.thickness =
            std::max(section.thickness, (section.at(0, share) - section.at(1, share)).norm());
    }
    const Vec3 forward = (section.nose() - section.trailing_edge()).normalized();
    const auto curvature = reference.curvature(reference.foot_point(section.nose(), forward));
    const double bend =
        curvature ? std::max(std::abs(curvature->value[0]), std::abs(curvature->value[1])) : 0.0;
    section.nose_radius = bend > 0.0 ? 1.0 / bend : section.thickness;
}

bool is_one_loop(const std::vector<SectionLoop>& loops) {
    return loops.size() == 1 && loops[0].closed && int(loops[0].points.size()) >= fewest_points;
}

std::vector<int> points_of(const std::vector<Crossing>& crossings, const std::set<int>& curves) {
    std::vector<int> points;
    for (const Crossing& c : crossings)
        if (curves.contains(c.curve)) points.push_back(c.point);
    return points;
}

}  // namespace

bool WingSection::thin() const { return thickness < thickest * chord; }

void WingSection::open_tail() {
    for (const int side : {0, 1}) {
        const double share = half_width_opened * chord / length(side);
        const Vec3 first = at(side, share);
        auto& points = sides[std::size_t(side)];
        if (side == 1) std::reverse(points.begin(), points.end());
        while (points.size() > 2 && (points[1] - points[0]).norm() < (first - points[0]).norm())
            points.erase(points.begin() + 1);
        points.front() = first;
        if (side == 1) std::reverse(points.begin(), points.end());
    }
    blunt = true;
}

double WingSection::length(int side) const { return geom::length_of(sides[std::size_t(side)]); }

Vec3 WingSection::at(int side, double share) const {
    return geom::point_along(sides[std::size_t(side)], side == 0 ? share : 1.0 - share);
}

std::optional<std::array<int, 2>> tail_curves(const std::vector<SectionLoop>& loops,
                                              const geom::ModelSurface& reference) {
    if (!is_one_loop(loops)) return std::nullopt;
    const SectionLoop& loop = loops[0];
    const double length = loop.length();
    double least = widest_wedge_rad;
    std::optional<std::array<int, 2>> curves;
    const std::vector<Crossing> sharp = crossings_of(loop, reference);
    for (const Crossing& a : sharp) {
        for (const Crossing& b : sharp) {
            const Vec3 pa = loop.points[std::size_t(a.point)],
                       pb = loop.points[std::size_t(b.point)];
            const bool same = a.point == b.point;
            // Half of the way around is about the chord.
            if (!same && (pa - pb).norm() > 0.5 * widest_trailing_edge * length) continue;
            if (!same && way_between(loop, a.point, b.point) > 2.0 * (pa - pb).norm()) continue;
            const Vec3 before = walk(loop, a.point, wedge_reach * length, -1) - pa;
            const Vec3 after = walk(loop, b.point, wedge_reach * length, 1) - pb;
            const double angle =
                geom::angle_between(before, after) + (same ? prefers_pairs_rad : 0.0);
            if (angle >= least) continue;
            least = angle;
            curves = {a.curve, b.curve};
        }
    }
    return curves;
}

std::set<int> nose_curves(const std::vector<SectionLoop>& loops, const std::set<int>& tail,
                          const geom::ModelSurface& reference) {
    std::set<int> curves;
    if (!is_one_loop(loops)) return curves;
    const SectionLoop& loop = loops[0];
    const std::vector<Crossing> sharp = crossings_of(loop, reference);
    const std::vector<int> edges = points_of(sharp, tail);
    if (edges.empty()) return curves;
    const Vec3 end = loop.points[std::size_t(edges.front())];
    double chord = 0.0;
    for (const Vec3& p : loop.points) chord = std::max(chord, (p - end).norm());
    for (const Crossing& c : sharp)
        if (!tail.contains(c.curve) &&
            (loop.points[std::size_t(c.point)] - end).norm() > (1.0 - nose_zone) * chord)
            curves.insert(c.curve);
    return curves;
}

SectionResult wing_section(const std::vector<SectionLoop>& loops, const WingLines& lines,
                           const geom::ModelSurface& reference, const WingSection* like) {
    if (loops.size() != 1) return {{}, fmt::format("{} lines", loops.size())};
    const SectionLoop& loop = loops[0];
    if (!loop.closed) return {{}, "an open line"};
    if (int(loop.points.size()) < fewest_points) return {{}, "a line of a few points only"};
    const std::vector<Crossing> crossings = crossings_of(loop, reference, lines.nose);
    std::vector<int> edges = points_of(crossings, lines.tail);
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    if (edges.size() > 2) return {{}, fmt::format("a trailing edge of {} lines", edges.size())};
    if (edges.empty() && like == nullptr) return {{}, "no trailing edge"};
    WingSection section;
    section.faded = edges.empty();
    const Tail tail = section.faded ? tail_like(loop, *like) : tail_at(loop, edges);
    section.blunt = tail.first != tail.last;
    const std::vector<Vec3> around = without_tail(loop, tail);
    const Vec3 end = 0.5 * (around.front() + around.back());
    std::size_t nose = 0;
    for (std::size_t i = 0; i < around.size(); ++i)
        if ((around[i] - end).norm() > (around[nose] - end).norm()) nose = i;
    section.chord = (around[nose] - end).norm();
    for (const Crossing& c : crossings) {
        if (lines.tail.contains(c.curve) || lines.around.contains(c.curve)) continue;
        const Vec3& p = loop.points[std::size_t(c.point)];
        // At the end of a trailing edge there may be a line across it.
        if ((p - end).norm() < across_tail * section.chord + (around.front() - end).norm())
            continue;
        if ((p - around[nose]).norm() > nose_zone * section.chord)
            return {{},
                    fmt::format("a sharp line at {:.0f} % of the chord",
                                100.0 * (p - end).norm() / section.chord)};
        if (lines.nose.contains(c.curve)) {
            section.nose_on_line = true;
            const int count = int(loop.points.size());
            nose = std::size_t((c.point - tail.last + count) % count);
        }
    }
    if (nose < 2 || nose + 3 > around.size()) return {{}, "a side of a few points only"};
    section.sides[0].assign(around.begin(), around.begin() + std::ptrdiff_t(nose) + 1);
    section.sides[1].assign(around.begin() + std::ptrdiff_t(nose), around.end());
    section.center = center_of(loop);
    if (section.blunt && (around.front() - around.back()).norm() > widest_followed * section.chord)
        return {{}, "a trailing edge wider than a quarter of the chord"};
    measure_form(section, reference);
    return {section, ""};
}

}  // namespace patchwright::cage
