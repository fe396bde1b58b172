#include "cage/blocks/feature_chain.h"
#include "cage/sections/bent_spine.h"
#include "cage/sections/part_left_out.h"
#include "cage/sections/wing_columns.h"
#include "cage/sections/wing_finder.h"
#include "geom/angle.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>

namespace patchwright::cage {

using geom::Vec3;

namespace {

constexpr int samples_along = 13;
// Of the span, from either end: tips are rounded or cut at an angle there.
constexpr double outermost_sample = 0.08;
// Of the mean chord: shorter bodies with wing-like sections are fairings and fins of other parts.
constexpr double shortest_span = 0.4;
// A bend: more than that between both ends of an interval.
constexpr double bend_rad = 0.1;
// Beside a bend or a tip that closes the last interval of the span must not be much longer than the
// tip, or the limit surface swings: more than `long_beside_tip` tips long it is parted at
// `part_beside_tip`.
constexpr double long_beside_tip = 6.0, part_beside_tip = 2.5;

/// The axes, longest extent of the body first.
std::vector<Vec3> box_axes(const SurfaceBody& body) {
    geom::Box3 box;
    for (const int t : body.triangles)
        for (const int v : body.mesh->triangles[std::size_t(t)])
            box.add(body.mesh->points.row(v).transpose());
    const Vec3 extent = box.max - box.min;
    std::array<int, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int a, int b) { return extent[a] > extent[b]; });
    return {Vec3::Unit(order[0]), Vec3::Unit(order[1]), Vec3::Unit(order[2])};
}

/// Directions that the span may have: across flat lids first, the largest one before all, then the
/// axes, longest first.
std::vector<Vec3> possible_axes(const SurfaceBody& body) {
    const geom::SurfaceMesh& mesh = *body.mesh;
    std::map<int, std::pair<Vec3, double>> faces;  // area vector and area by face
    for (const int t : body.triangles) {
        const auto& c = mesh.triangles[std::size_t(t)];
        const Vec3 a = mesh.points.row(c[0]), b = mesh.points.row(c[1]), d = mesh.points.row(c[2]);
        const Vec3 area = 0.5 * (b - a).cross(d - a);
        auto& sum = faces.try_emplace(mesh.faces[std::size_t(t)], Vec3::Zero(), 0.0).first->second;
        sum.first += area;
        sum.second += area.norm();
    }
    constexpr double same_axis_cosine = 1.0 - 1e-6, flat_share = 1.0 - 1e-9;
    std::vector<Vec3> axes;
    const auto add = [&](Vec3 axis) {
        for (const Vec3& other : axes)
            if (std::abs(axis.dot(other)) > same_axis_cosine) return;
        // The same direction whichever lid it comes from.
        int largest = 0;
        axis.cwiseAbs().maxCoeff(&largest);
        axes.push_back(axis[largest] < 0.0 ? Vec3(-axis) : axis);
    };
    std::vector<std::pair<double, Vec3>> flat;
    for (const auto& [face, sum] : faces)
        if (sum.first.norm() > flat_share * sum.second) flat.emplace_back(sum.second, sum.first);
    // A rib counts before the end of a blunt trailing edge.
    std::stable_sort(flat.begin(), flat.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    for (const auto& [area, sum] : flat) add(sum.normalized());
    for (const Vec3& axis : box_axes(body)) add(axis);
    return axes;
}

const char* name_of(EndKind kind) {
    switch (kind) {
        case EndKind::Lid: return "planar";
        case EndKind::Open: return "open";
        case EndKind::Rounded: return "rounded";
        case EndKind::Ridge: return "sharp";
    }
    return "";
}

}  // namespace

std::optional<Wing> WingFinder::run() {
    if (!is_wing()) return std::nullopt;
    for (WingEnd& end : wing_.ends)
        if (!classify(end)) return std::nullopt;
    if (!all_lines_known()) return std::nullopt;
    find_span_of_lines();
    for (const double height : stations())
        if (!add_section(height)) return std::nullopt;
    return std::move(wing_);
}

const WingSection* WingFinder::known_near(double height) const {
    const WingSection* best = nullptr;
    double distance = 0.0;
    for (const auto& [h, section] : known_) {
        if (best != nullptr && std::abs(h - height) >= distance) continue;
        best = &section;
        distance = std::abs(h - height);
    }
    return best;
}

bool WingFinder::is_wing() {
    if (!(wing_.span > 0.0)) return refuse("flat");
    SectionCuts cuts;
    find_lines_around();
    if (!find_tail(cuts)) return false;
    find_nose(cuts);
    return all_are_sections(cuts);
}

bool WingFinder::find_tail(SectionCuts& cuts) {
    int wedges = 0;
    for (int i = 0; i < samples_along; ++i) {
        poll_();
        const double share =
            outermost_sample + (1.0 - 2.0 * outermost_sample) * i / (samples_along - 1);
        const double height = wing_.slicer.low() + wing_.span * share;
        const auto& loops = cuts[height] = wing_.slicer.cut(height);
        const auto tail = tail_curves(loops, reference_);
        if (!tail && 2 * (i - wedges) > samples_along) break;
        if (!tail) continue;
        ++wedges;
        wing_.lines.tail.insert(tail->begin(), tail->end());
    }
    found_ = wedges;
    if (2 * wedges < samples_along)
        return refuse(fmt::format("{} of {} sections have one thin sharp trailing edge", wedges,
                                  samples_along));
    return true;
}

void WingFinder::find_nose(const SectionCuts& cuts) {
    int at_nose = 0;
    std::set<int> nose;
    for (const auto& [height, loops] : cuts) {
        const auto curves = nose_curves(loops, wing_.lines.tail, reference_);
        at_nose += curves.empty() ? 0 : 1;
        nose.insert(curves.begin(), curves.end());
    }
    wing_.nose_line = 2 * at_nose > samples_along;
    if (!wing_.nose_line) return;
    wing_.lines.nose = nose;
    // Where it goes on smoothly it is still one line.
    for (const int curve : nose)
        for (const bool backwards : {false, true})
            for (const int next : chain_from(curve, backwards, reference_).curves)
                if (reference_.features().curves[std::size_t(next)].kind ==
                    geom::FeatureKind::Smooth)
                    wing_.lines.nose.insert(next);
}

bool WingFinder::all_are_sections(const SectionCuts& cuts) {
    for (const auto& [height, loops] : cuts) {
        auto result = wing_section(loops, wing_.lines, reference_);
        if (result.section) known_.emplace(height, std::move(*result.section));
    }
    int thin = 0, blunt = 0;
    double chords = 0.0;
    std::map<Height, WingSection> all;
    for (const auto& [height, loops] : cuts) {
        poll_();
        const auto result = wing_section(loops, wing_.lines, reference_, known_near(height));
        if (!result.section)
            return refuse(fmt::format("the section {} has {}", percent(height), result.why));
        thin += result.section->thin() ? 1 : 0;
        blunt += result.section->blunt ? 1 : 0;
        chords += result.section->chord;
        all.emplace(height, *result.section);
        ++found_;
    }
    known_ = std::move(all);
    wing_.blunt = blunt > 0;
    wing_.blade = thin < samples_along;
    if (2 * thin < samples_along) return refuse("most sections are thick");
    if (blunt > 0 && blunt < samples_along)
        return refuse("the trailing edge is sharp here and blunt there");
    if (wing_.span < shortest_span * chords / samples_along)
        return refuse("the span is short for its chord");
    return true;
}

std::vector<double> WingFinder::stations() const {
    const double low = wing_.ends[0].ring, high = wing_.ends[1].ring;
    std::vector<double> inner = line_ends_, others = lines_around();
    const std::vector<double> planes = wing_.slicer.spine().inner_heights();
    for (std::size_t i = 0; i < planes.size(); ++i)
        if ((i > 0 && spine_bends(planes[i - 1], planes[i])) ||
            (i + 1 < planes.size() && spine_bends(planes[i], planes[i + 1])))
            others.push_back(planes[i]);
    for (const double h : others)
        if (std::none_of(line_ends_.begin(), line_ends_.end(),
                         [&](double end) { return std::abs(h - end) < distinct_rel * wing_.span; }))
            inner.push_back(h);
    std::sort(inner.begin(), inner.end());
    std::vector<double> fixed{low};
    for (const double h : inner)
        if (h - fixed.back() > distinct_rel * wing_.span && high - h > distinct_rel * wing_.span)
            fixed.push_back(h);
    fixed.push_back(high);
    std::vector<double> result;
    for (std::size_t i = 0; i + 1 < fixed.size(); ++i) {
        const double a = fixed[i], b = fixed[i + 1];
        const int pieces = std::max(1, int(std::lround((b - a) / wing_.span * options_.spans)));
        for (int k = 0; k < pieces; ++k) result.push_back(a + (b - a) * k / pieces);
    }
    result.push_back(high);
    add_where_bent(result);
    part_beside_bends(result);
    const auto closes = [](const WingEnd& end) {
        return end.kind == EndKind::Rounded || end.kind == EndKind::Ridge;
    };
    const double tip_low = low - wing_.ends[0].extreme, tip_high = wing_.ends[1].extreme - high;
    if (closes(wing_.ends[1]) && high - result[result.size() - 2] > long_beside_tip * tip_high)
        result.insert(result.end() - 1, high - part_beside_tip * tip_high);
    if (closes(wing_.ends[0]) && result[1] - low > long_beside_tip * tip_low)
        result.insert(result.begin() + 1, low + part_beside_tip * tip_low);
    return result;
}

bool WingFinder::spine_bends(double low, double high) const {
    const Spine& spine = wing_.slicer.spine();
    return geom::angle_between(spine.direction(low), spine.direction(high)) > bend_rad;
}

void WingFinder::part_beside_bends(std::vector<double>& heights) const {
    std::vector<double> parts;
    for (std::size_t i = 1; i + 2 < heights.size(); ++i) {
        const double a = heights[i], b = heights[i + 1], step = part_beside_tip * (b - a);
        if (!spine_bends(a, b)) continue;
        const double before = heights[i - 1], after = heights[i + 2];
        if (a - before > long_beside_tip * (b - a) && !spine_bends(before, a))
            parts.push_back(a - step);
        if (after - b > long_beside_tip * (b - a) && !spine_bends(b, after))
            parts.push_back(b + step);
    }
    heights.insert(heights.end(), parts.begin(), parts.end());
    std::sort(heights.begin(), heights.end());
}

void WingFinder::add_where_bent(std::vector<double>& heights) const {
    // Of the chord: what a fit of one cubic span takes out of a bent one. Of the span: an interval;
    // of the chord: one in a bend of the spine.
    constexpr double straight = 0.02, shortest_rel = 0.02, shortest_chords = 0.15;
    const auto points_of = [](const WingSection& s) {
        return std::array<Vec3, 4>{s.trailing_edge(), s.at(0, 0.5), s.nose(), s.at(1, 0.5)};
    };
    for (std::size_t i = 0; i + 1 < heights.size();) {
        const double low = heights[i], span = heights[i + 1] - low;
        const auto a = section_at(low).section, b = section_at(low + span).section;
        bool bent = false;
        double shortest = shortest_rel * wing_.span;
        // A line may bend to both sides and pass through the middle.
        for (const double share : {0.25, 0.5, 0.75}) {
            const auto m = section_at(low + share * span).section;
            if (m && spine_bends(low, low + span))
                shortest = std::min(shortest, shortest_chords * m->chord);
            for (std::size_t k = 0; k < 4 && a && b && m; ++k) {
                const Vec3 between = (1.0 - share) * points_of(*a)[k] + share * points_of(*b)[k];
                bent = bent || (between - points_of(*m)[k]).norm() >
                                   straight * m->chord / options_.fineness;
            }
        }
        if (bent && span > 2.0 * shortest)
            heights.insert(heights.begin() + std::ptrdiff_t(i) + 1, low + 0.5 * span);
        else
            ++i;
    }
}

bool WingFinder::add_section(double height) {
    SectionResult result;
    const WingEnd* open = nullptr;
    for (const WingEnd& end : wing_.ends) {
        if (end.kind != EndKind::Open) continue;
        if (height == end.ring) {
            open = &end;
            continue;
        }
        double reach = 0.0;
        for (const Vec3& p : end.rim.points)
            reach = std::max(reach, std::abs(wing_.slicer.spine().height(p) - end.extreme));
        constexpr double clear_of_rim = 1.5;  // times how far a slanting rim reaches inward
        if (reach > flat_rel * wing_.span && std::abs(height - end.extreme) < clear_of_rim * reach)
            return true;
    }
    result = open == nullptr
                 ? section_at(height)
                 : wing_section({open->rim}, wing_.lines, reference_, known_near(height));
    if (!result.section)
        return refuse(fmt::format("the section {} has {}", percent(height), result.why));
    // A blunt trailing edge may close in a point at an end.
    if (wing_.blunt && !result.section->blunt && !result.section->faded && open != nullptr)
        result.section->open_tail();
    if (result.section->blunt != wing_.blunt)
        return refuse(fmt::format("the trailing edge is sharp or blunt only {}", percent(height)));
    if (!wing_.sections.empty())
        wing_.nose_on_line.push_back(wing_.sections.back().nose_on_line &&
                                     result.section->nose_on_line);
    wing_.sections.push_back(std::move(*result.section));
    wing_.heights.push_back(height);
    ++found_;
    return true;
}

WingSearch find_wing(const SurfaceBody& body, const geom::ModelSurface& reference,
                     const WingOptions& options, Poll& poll) {
    WingSearch result;
    int most = -1;
    const auto try_along = [&](const Vec3& axis, WingFinder finder) {
        result.wing = finder.run();
        std::string why_not = finder.why_not();
        if (result.wing) {
            result.blocks = wing_blocks(*result.wing, reference, options, poll);
            const auto left_out = part_left_out(body, *result.wing, result.blocks, poll);
            if (!left_out) return;
            result.wing.reset();
            why_not = fmt::format("the sections leave out what is at ({:.4g}, {:.4g}, {:.4g})",
                                  left_out->x(), left_out->y(), left_out->z());
        }
        if (finder.sections_found() <= most) return;
        most = finder.sections_found();
        result.why_not =
            fmt::format("along ({:.2f}, {:.2f}, {:.2f}) {}", axis.x(), axis.y(), axis.z(), why_not);
    };
    // Before straight ones, which may take a winglet for a rounded tip.
    for (const Vec3& axis : box_axes(body)) {
        const auto bent = bent_spine(body, reference, axis, poll);
        if (!bent) continue;
        try_along(axis, {body, reference, options, bent->spine, poll, bent->tail});
        if (result.wing) return result;
    }
    for (const Vec3& axis : possible_axes(body)) {
        try_along(axis, {body, reference, options, Spine(axis), poll});
        if (result.wing) return result;
    }
    return result;
}

std::string describe(const Wing& wing, const WingOptions& options) {
    const bool fades = std::any_of(wing.sections.begin(), wing.sections.end(),
                                   [](const WingSection& s) { return s.faded; });
    int rings = int(wing.sections.size());
    for (const WingEnd& end : wing.ends) rings += end.kind == EndKind::Rounded ? 1 : 0;
    return fmt::format("{}: {} points around x {} rings, {} trailing edge{}{}, ends {} and {}",
                       wing.blade ? "blade" : "wing",
                       RingColumns{options.columns, wing.blunt, wing.nose_line}.size(), rings,
                       wing.blunt ? "blunt" : "sharp", fades ? " that fades" : "",
                       wing.nose_line ? ", line along the nose" : "", name_of(wing.ends[0].kind),
                       name_of(wing.ends[1].kind));
}

}  // namespace patchwright::cage
