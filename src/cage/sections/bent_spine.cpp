#include "cage/sections/bent_spine.h"

#include "cage/sections/wing_section.h"
#include "geom/angle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Sections along the axis at which the trailing edge is looked for.
constexpr int tail_samples = 13;
// Of the chord: the longest and the shortest step along the trailing edge. A bend is found as near
// as the shortest; beyond it the edge goes on after some of them.
constexpr double longest_step = 0.25, shortest_step = 0.01, steps_past_bend = 8.0;
// Between a section's normal and the way to its trailing edge, seen along the chord.
constexpr double most_askew_rad = 0.4;
// Of a step: how far the trailing edge goes at most. Usual ones are swept by 50 degrees at most.
constexpr double farthest_in_steps = 3.0;
// Turns that are tried at a bend, either way: six of 15 degrees.
constexpr double bend_step_rad = std::numbers::pi / 12.0;
constexpr int bend_steps = 6;
// More steps are no wing's: its sides are some twenty chords long at most.
constexpr int most_steps = 400;
// Of the chord: points of the edge nearer to a straight way are on it; half of a section's
// thickness is three times as much.
constexpr double straight_rel = 0.02;
// Of the chord: this far from a bend sections are square again. Half a thickness is a tenth of it
// or so, which a fan of planes clears.
constexpr double fan_reach = 0.4;
// Between two parts of the way: 29 degrees. Less is dihedral, which straight cuts do well.
constexpr double least_bend_rad = 0.5;
// Of the chord: what may lie beyond the last sections that have a trailing edge.
constexpr double longest_tip = 0.5;
// Between the way and the normal of a flat end.
constexpr double most_slanted_end_rad = 1.0;
// Area of triangles over the length of their sum, less 1, from which on a face is not flat.
constexpr double flat_face_share = 1e-9;

/// A point of the trailing edge.
struct TailPoint {
    Vec3 point;
    double chord = 0.0;
    Vec3 chordwise;  ///< from the nose
    std::array<int, 2> curves{};
};

/// A flat face or border that a wing may end with.
struct FlatEnd {
    Vec3 centre, normal;
};

std::optional<TailPoint> tail_point(const SectionLoop& loop, const geom::ModelSurface& reference) {
    const auto curves = tail_curves({loop}, reference);
    if (!curves) return std::nullopt;
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (const Crossing& c : loop.crossings) {
        if (c.curve != (*curves)[0] && c.curve != (*curves)[1]) continue;
        sum += loop.points[std::size_t(c.point)];
        ++count;
    }
    TailPoint tail{sum / count, 0.0, Vec3::Zero(), *curves};
    for (const Vec3& p : loop.points) {
        if ((tail.point - p).norm() <= tail.chord) continue;
        tail.chord = (tail.point - p).norm();
        tail.chordwise = tail.point - p;
    }
    return tail;
}

/// Follows the trailing edge section by section.
class TailTracer {
  public:
    TailTracer(const SurfaceBody& body, const geom::ModelSurface& reference, Poll& poll)
        : body_(body), reference_(reference), poll_(poll) {}

    /// Points from end to end and the direction that is chordwise all along.
    bool run(const Vec3& axis) {
        const auto start = middle_of(axis);
        if (!start) return false;
        chordwise = (start->chordwise - start->chordwise.dot(axis) * axis).normalized();
        points = follow(*start, -axis);
        std::reverse(points.begin(), points.end());
        points.push_back(*start);
        const auto upward = follow(*start, axis);
        points.insert(points.end(), upward.begin(), upward.end());
        return points.size() > 2;
    }

    std::vector<TailPoint> points;
    Vec3 chordwise = Vec3::Zero();

  private:
    /// The middle one of sections along an axis, most of which have a trailing edge.
    std::optional<TailPoint> middle_of(const Vec3& axis) {
        const Slicer slicer(body_, Spine(axis));
        std::optional<TailPoint> middle;
        int found = 0;
        for (int i = 0; i < tail_samples; ++i) {
            poll_();
            const double share = (i + 0.5) / tail_samples;
            const auto loops = slicer.cut(slicer.low() + share * (slicer.high() - slicer.low()));
            if (loops.size() == 1 && loops[0].closed) {
                const auto tail = tail_point(loops[0], reference_);
                found += tail ? 1 : 0;
                if (tail && (!middle || i <= tail_samples / 2)) middle = tail;
            }
            if (2 * (i + 1 - found) > tail_samples) return std::nullopt;
        }
        return middle;
    }

    [[nodiscard]] Vec3 across(const Vec3& v) const { return v - v.dot(chordwise) * chordwise; }

    /// The trailing edge a step on in a direction, where it goes about that way.
    std::optional<TailPoint> step(const Vec3& from, const Vec3& direction, double length) {
        poll_();
        const Slicer slicer(body_, Spine(direction));
        std::optional<TailPoint> best;
        for (const SectionLoop& loop : slicer.cut(from.dot(direction) + length)) {
            if (!loop.closed) continue;
            const auto tail = tail_point(loop, reference_);
            if (!tail) continue;
            const Vec3 way = tail->point - from;
            if (way.norm() > farthest_in_steps * length ||
                geom::angle_between(across(way), direction) > most_askew_rad)
                continue;
            if (!best || way.norm() < (best->point - from).norm()) best = tail;
        }
        return best;
    }

    /// Where the edge bends, the next point past the bend.
    std::optional<TailPoint> past_bend(const TailPoint& at, const Vec3& direction) {
        for (int k = 1; k <= bend_steps; ++k)
            for (const double sign : {1.0, -1.0}) {
                const Eigen::AngleAxisd turn(sign * k * bend_step_rad, chordwise);
                const auto next =
                    step(at.point, turn * direction, steps_past_bend * shortest_step * at.chord);
                if (next) return next;
            }
        return std::nullopt;
    }

    std::vector<TailPoint> follow(TailPoint at, Vec3 direction) {
        std::vector<TailPoint> line;
        for (int i = 0; i < most_steps; ++i) {
            std::optional<TailPoint> next;
            for (double length = longest_step; !next && length > shortest_step; length *= 0.5)
                next = step(at.point, direction, length * at.chord);
            if (!next) next = past_bend(at, direction);
            if (!next) break;
            direction = across(next->point - at.point).normalized();
            at = *next;
            line.push_back(at);
        }
        return line;
    }

    const SurfaceBody& body_;
    const geom::ModelSurface& reference_;
    Poll& poll_;
};

std::vector<FlatEnd> flat_ends(const SurfaceBody& body) {
    const geom::SurfaceMesh& mesh = *body.mesh;
    struct Sum {
        Vec3 area = Vec3::Zero(), moment = Vec3::Zero();
        double size = 0.0;
    };
    std::map<int, Sum> faces;
    for (const int t : body.triangles) {
        const auto& c = mesh.triangles[std::size_t(t)];
        const Vec3 a = mesh.points.row(c[0]), b = mesh.points.row(c[1]), d = mesh.points.row(c[2]);
        const Vec3 area = 0.5 * (b - a).cross(d - a);
        Sum& sum = faces[mesh.faces[std::size_t(t)]];
        sum.area += area;
        sum.size += area.norm();
        sum.moment += area.norm() / 3.0 * (a + b + d);
    }
    std::vector<FlatEnd> ends;
    for (const auto& [face, sum] : faces)
        if (sum.area.norm() > (1.0 - flat_face_share) * sum.size)
            ends.push_back({sum.moment / sum.size, sum.area.normalized()});
    for (const SectionLoop& rim : rims(body)) {
        Vec3 area = Vec3::Zero(), middle = Vec3::Zero();
        for (const Vec3& p : rim.points) middle += p / double(rim.points.size());
        for (std::size_t i = 0; i < rim.points.size(); ++i)
            area +=
                (rim.points[i] - middle).cross(rim.points[(i + 1) % rim.points.size()] - middle);
        ends.push_back({middle, area.normalized()});
    }
    return ends;
}

/// Where the way ends: at a flat end across it, or at the last point of the trailing edge.
Spine::Plane end_plane(const TailPoint& last, const Vec3& outward, const Vec3& chordwise,
                       const std::vector<FlatEnd>& ends) {
    Spine::Plane plane{last.point, outward};
    double nearest = longest_tip * last.chord;
    for (const FlatEnd& end : ends) {
        const Vec3 way = end.centre - last.point;
        const double distance = (way - way.dot(chordwise) * chordwise).norm();
        const Vec3 normal = end.normal.dot(outward) < 0.0 ? Vec3(-end.normal) : end.normal;
        if (distance > nearest || geom::angle_between(normal, outward) > most_slanted_end_rad)
            continue;
        nearest = distance;
        plane = {end.centre, normal};
    }
    return plane;
}

/// Points between which the way is straight, seen along the chord: the two given ones and those
/// in between that lie off it.
void add_corners(const std::vector<TailPoint>& points, const Vec3& chordwise, std::size_t first,
                 std::size_t last, std::vector<std::size_t>& corners) {
    const auto across = [&](const Vec3& v) { return Vec3(v - v.dot(chordwise) * chordwise); };
    const Vec3 along = across(points[last].point - points[first].point).normalized();
    std::size_t farthest = first;
    double most = 1.0;
    for (std::size_t i = first + 1; i < last; ++i) {
        const Vec3 way = across(points[i].point - points[first].point);
        const double off = (way - way.dot(along) * along).norm() / (straight_rel * points[i].chord);
        if (off <= most) continue;
        most = off;
        farthest = i;
    }
    if (farthest == first) return;
    add_corners(points, chordwise, first, farthest, corners);
    corners.push_back(farthest);
    add_corners(points, chordwise, farthest, last, corners);
}

/// Moves corners, which are as far off as a step is long, to where a curve of the trailing edge
/// ends nearby: wings bend where their parts meet. Those that come to lie together are one.
void place_corners(TailTracer& tail, std::vector<std::size_t>& corners,
                   const geom::ModelSurface& reference) {
    std::vector<std::size_t> placed{corners.front()};
    for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
        TailPoint& corner = tail.points[corners[k]];
        const Vec3 traced = corner.point;
        double nearest = longest_step * corner.chord;
        for (std::size_t i : {corners[k] - 1, corners[k], corners[k] + 1})
            for (const int c : tail.points[i].curves) {
                const geom::FeatureCurve& curve = reference.features().curves[std::size_t(c)];
                for (const Vec3& end : {curve.start, curve.end}) {
                    if ((end - traced).norm() >= nearest) continue;
                    nearest = (end - traced).norm();
                    corner.point = end;
                }
            }
        const Vec3 way = corner.point - tail.points[placed.back()].point;
        if (way.norm() > shortest_step * corner.chord) placed.push_back(corners[k]);
    }
    placed.push_back(corners.back());
    corners = std::move(placed);
}

/// Bisecting planes at corners, and square ones on both sides of them.
std::vector<Spine::Plane> planes_along(const TailTracer& tail,
                                       const std::vector<std::size_t>& corners,
                                       const std::vector<FlatEnd>& ends) {
    const auto at = [&](std::size_t k) -> const TailPoint& { return tail.points[corners[k]]; };
    const auto direction = [&](std::size_t k) {
        const Vec3 way = at(k + 1).point - at(k).point;
        return Vec3((way - way.dot(tail.chordwise) * tail.chordwise).normalized());
    };
    const std::size_t last = corners.size() - 1;
    std::vector<Spine::Plane> planes{end_plane(at(0), -direction(0), tail.chordwise, ends)};
    planes[0].normal = -planes[0].normal;
    for (std::size_t k = 0; k < last; ++k) {
        const Vec3 way = at(k + 1).point - at(k).point;
        const double length = way.dot(direction(k));
        for (const bool near_end : {false, true}) {
            const double reach = fan_reach * at(near_end ? k + 1 : k).chord / length;
            if (reach < 0.5)
                planes.push_back(
                    {at(k).point + (near_end ? 1.0 - reach : reach) * way, direction(k)});
        }
        if (k + 1 < last)
            planes.push_back({at(k + 1).point, (direction(k) + direction(k + 1)).normalized()});
    }
    planes.push_back(end_plane(at(last), direction(last - 1), tail.chordwise, ends));
    return planes;
}

}  // namespace

std::optional<BentSpine> bent_spine(const SurfaceBody& body, const geom::ModelSurface& reference,
                                    const Vec3& axis, Poll& poll) {
    TailTracer tail(body, reference, poll);
    if (!tail.run(axis)) return std::nullopt;
    std::vector<std::size_t> corners{0};
    add_corners(tail.points, tail.chordwise, 0, tail.points.size() - 1, corners);
    corners.push_back(tail.points.size() - 1);
    place_corners(tail, corners, reference);
    const auto planes = planes_along(tail, corners, flat_ends(body));
    double bend = 0.0;
    for (const Spine::Plane& plane : planes)
        bend = std::max(bend, geom::angle_between(plane.normal, planes[planes.size() / 2].normal));
    if (bend < least_bend_rad) return std::nullopt;
    Spine spine(planes, tail.chordwise);
    const Slicer slicer(body, spine);
    if (-slicer.low() > longest_tip * tail.points.front().chord ||
        slicer.high() - spine.length() > longest_tip * tail.points.back().chord)
        return std::nullopt;
    BentSpine bent{spine, {}};
    for (const TailPoint& p : tail.points) bent.tail.insert(p.curves.begin(), p.curves.end());
    return bent;
}

}  // namespace patchwright::cage
