#include "layout/wing_section.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::layout {

using geom::Vec3;

namespace {

// Of the chord: two edges nearer than this are one blunt trailing edge.
constexpr double widest_trailing_edge = 0.06;
constexpr double thickest = 0.45;  // of the chord; thicker sections are no wing's

std::vector<int> sharp_points(const SectionLoop& loop, const geom::Features& features) {
    std::vector<int> points;
    for (const Crossing& c : loop.crossings)
        if (features.curves[std::size_t(c.curve)].kind == geom::FeatureKind::Sharp)
            points.push_back(c.point);
    return points;
}

/// The loop from one point on, all the way around.
std::vector<Vec3> turned(const SectionLoop& loop, int first) {
    std::vector<Vec3> points(loop.points);
    std::rotate(points.begin(), points.begin() + first, points.end());
    return points;
}

}  // namespace

double WingSection::length(int side) const {
    const auto& s = sides[std::size_t(side)];
    double sum = 0.0;
    for (std::size_t i = 1; i < s.size(); ++i) sum += (s[i] - s[i - 1]).norm();
    return sum;
}

Vec3 WingSection::at(int side, double share) const {
    const auto& s = sides[std::size_t(side)];
    double left = (side == 0 ? share : 1.0 - share) * length(side);
    for (std::size_t i = 1; i < s.size(); ++i) {
        const double step = (s[i] - s[i - 1]).norm();
        if (left <= step && step > 0.0) return s[i - 1] + left / step * (s[i] - s[i - 1]);
        left -= step;
    }
    return s.back();
}

std::optional<WingSection> wing_section(const std::vector<SectionLoop>& loops,
                                        const geom::Features& features,
                                        const occ::CadReference& reference) {
    if (loops.size() != 1 || !loops[0].closed || loops[0].points.size() < 8) return std::nullopt;
    const SectionLoop& loop = loops[0];
    const std::vector<int> edges = sharp_points(loop, features);
    if (edges.empty() || edges.size() > 2) return std::nullopt;
    WingSection section;
    section.blunt = edges.size() == 2;
    std::vector<Vec3> around = turned(loop, edges[0]);
    if (section.blunt) {
        // From the end of the strip between both edges to its start.
        const int count = int(around.size());
        const int other = (edges[1] - edges[0] + count) % count;
        const SectionLoop part{{around.begin(), around.begin() + other + 1}, false, {}};
        if (part.length() < 0.5 * loop.length()) {
            around = turned(loop, edges[1]);
            around.resize(std::size_t(count - other + 1));
        } else {
            around.resize(std::size_t(other + 1));
        }
    } else {
        around.push_back(around.front());
    }
    const Vec3 tail = 0.5 * (around.front() + around.back());
    std::size_t nose = 0;
    for (std::size_t i = 0; i < around.size(); ++i)
        if ((around[i] - tail).norm() > (around[nose] - tail).norm()) nose = i;
    if (nose < 2 || nose + 3 > around.size()) return std::nullopt;
    section.sides[0].assign(around.begin(), around.begin() + std::ptrdiff_t(nose) + 1);
    section.sides[1].assign(around.begin() + std::ptrdiff_t(nose), around.end());
    section.chord = (around[nose] - tail).norm();
    if (section.blunt &&
        (around.front() - around.back()).norm() > widest_trailing_edge * section.chord)
        return std::nullopt;
    for (int i = 1; i < 20; ++i)
        section.thickness =
            std::max(section.thickness, (section.at(0, i / 20.0) - section.at(1, i / 20.0)).norm());
    if (section.thickness > thickest * section.chord) return std::nullopt;
    const Vec3 forward = (around[nose] - tail).normalized();
    const auto curvature = reference.curvature(reference.foot_point(around[nose], forward));
    const double bend =
        curvature ? std::max(std::abs(curvature->value[0]), std::abs(curvature->value[1])) : 0.0;
    section.nose_radius = bend > 0.0 ? 1.0 / bend : section.thickness;
    return section;
}

}  // namespace patchwright::layout
