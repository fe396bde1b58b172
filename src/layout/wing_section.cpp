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
constexpr double widest_wedge_rad = 1.0;
// Of the chord: a sharp line this near to the nose is a flaw of the model, not a feature.
constexpr double nose_zone = 0.04;

std::vector<int> sharp_points(const SectionLoop& loop, const geom::Features& features) {
    std::vector<int> points;
    for (const Crossing& c : loop.crossings)
        if (features.curves[std::size_t(c.curve)].kind == geom::FeatureKind::Sharp)
            points.push_back(c.point);
    return points;
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

/// First and last point of the trailing edge, in the loop's direction: equal when it is sharp.
struct Tail {
    int first, last;
};

/// The wedge with the least angle at a sharp point, or at two that are near each other.
std::optional<Tail> find_tail(const SectionLoop& loop, const std::vector<int>& sharp) {
    const double length = loop.length();
    double least = widest_wedge_rad;
    std::optional<Tail> tail;
    for (const int a : sharp) {
        for (const int b : sharp) {
            const Vec3 pa = loop.points[std::size_t(a)], pb = loop.points[std::size_t(b)];
            // Half of the way around is about the chord.
            if (a != b && (pa - pb).norm() > 0.5 * widest_trailing_edge * length) continue;
            if (a != b && (walk(loop, a, (pa - pb).norm(), 1) - pb).norm() > 0.5 * (pa - pb).norm())
                continue;
            const Vec3 before = walk(loop, a, 0.05 * length, -1) - pa;
            const Vec3 after = walk(loop, b, 0.05 * length, 1) - pb;
            const double angle =
                std::atan2(before.cross(after).norm(), before.dot(after)) + (a == b ? 1e-3 : 0.0);
            if (angle >= least) continue;
            least = angle;
            tail = Tail{a, b};
        }
    }
    return tail;
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
                                        const geom::ModelSurface& reference) {
    if (loops.size() != 1 || !loops[0].closed || loops[0].points.size() < 8) return std::nullopt;
    const SectionLoop& loop = loops[0];
    const std::vector<int> sharp = sharp_points(loop, features);
    const auto edges = find_tail(loop, sharp);
    if (!edges) return std::nullopt;
    WingSection section;
    section.blunt = edges->first != edges->last;
    const int count = int(loop.points.size());
    std::vector<Vec3> around = turned(loop, edges->last);
    if (section.blunt) {
        around.resize(std::size_t((edges->first - edges->last + count) % count + 1));
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
    for (const int i : sharp) {
        const Vec3& p = loop.points[std::size_t(i)];
        if (i != edges->first && i != edges->last &&
            (p - around[nose]).norm() > nose_zone * section.chord)
            return std::nullopt;
    }
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
