#include "support/analytic_wing.h"

#include "support/cages.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::test {

using geom::Vec3;

namespace {

constexpr double span = 4.0, sweep = 1.5, root = 2.0, tip = 1.0;
constexpr int steps = 4096;  // of the table of arc lengths
constexpr int coarse = 96;   // places where Newton's method may start

double nose_at(double t) { return sweep * t; }
double chord_at(double t) { return root + (tip - root) * t; }

/// Half thickness at x = s^2 for chord 1 and its derivatives; odd in s.
Vec3 profile(WingSection section, double s) {
    const double a = std::abs(s), sign = s < 0 ? -1.0 : 1.0, b = a * a;
    if (section == WingSection::Smooth) {
        return 0.17814 *
               Vec3(s * (1 - b * (4 - b) / 3), 1 - b * (12 - 5 * b) / 3, s * (20 * b - 24) / 3);
    }
    const double z = a * (0.2969 - a * (0.1260 + b * (0.3516 - b * (0.2843 - b * 0.1036))));
    const double dz = 0.2969 - a * (0.2520 + b * (1.4064 - b * (1.7058 - b * 0.8288)));
    const double ddz = -0.2520 - b * (4.2192 - b * (8.5290 - b * 5.8016));
    return 0.6 * Vec3(sign * z, dz, sign * ddz);
}

struct Derivatives {
    Vec3 p, ds, dt, dss, dst;  // straight along t
};

Derivatives derivatives(WingSection section, double s, double t) {
    const Vec3 f = profile(section, s);
    const double c = chord_at(t), dc = tip - root;
    return {{nose_at(t) + c * s * s, span * t, c * f[0]},
            {2 * c * s, 0.0, c * f[1]},
            {sweep + dc * s * s, span, dc * f[0]},
            {2 * c, 0.0, c * f[2]},
            {2 * dc * s, 0.0, dc * f[1]}};
}

struct Hit {
    double s, t, distance;
};

/// From root to tip at one s.
struct Line {
    Vec3 start, along;
    [[nodiscard]] double nearest(const Vec3& q) const {
        return std::clamp((q - start).dot(along) / along.squaredNorm(), 0.0, 1.0);
    }
};

Line line_at(WingSection section, double s) {
    const Vec3 start = NacaWing::point(s, 0, section);
    return {start, NacaWing::point(s, 1, section) - start};
}

double nearest_t(WingSection section, double s, const Vec3& q) {
    return line_at(section, s).nearest(q);
}

/// Least distance along s from a start, t following, by bracketed Newton steps on its derivative.
Hit descend(WingSection section, double low, double high, const Vec3& q, double fixed_t) {
    const auto slope = [&](double s, double& second) {
        const double t = fixed_t >= 0 ? fixed_t : nearest_t(section, s, q);
        const Derivatives d = derivatives(section, s, t);
        const Vec3 r = d.p - q;
        second = d.ds.squaredNorm() + r.dot(d.dss);
        if (fixed_t < 0 && t > 0 && t < 1) {
            const double mixed = d.ds.dot(d.dt) + r.dot(d.dst);
            second -= mixed * mixed / d.dt.squaredNorm();
        }
        return r.dot(d.ds);
    };
    double s = 0.5 * (low + high);
    for (int i = 0; i < 60; ++i) {
        double second = 0.0;
        const double g = slope(s, second);
        (g > 0 ? high : low) = s;
        double next = second > 0 ? s - g / second : low - 1;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        if (std::abs(next - s) < 1e-16) break;
        s = next;
    }
    const double t = fixed_t >= 0 ? fixed_t : nearest_t(section, s, q);
    return {s, t, (NacaWing::point(s, t, section) - q).norm()};
}

Vec3 normal_at(WingSection section, double s, double t) {
    const Derivatives d = derivatives(section, s, t);
    return d.ds.cross(d.dt).normalized();
}

/// The nearest point, or the nearest whose normal is on the side of `side`.
Hit nearest(WingSection section, const Vec3& q, const std::optional<Vec3>& side, double fixed_t) {
    const auto at = [](int i) { return 2.0 * i / coarse - 1.0; };
    const auto lines_of = [&](WingSection of) {
        std::vector<Line> result;
        for (int i = 0; i <= coarse; ++i) result.push_back(line_at(of, at(i)));
        return result;
    };
    static const std::array all{lines_of(WingSection::Naca), lines_of(WingSection::Smooth)};
    const std::vector<Line>& lines = all[section == WingSection::Naca ? 0 : 1];
    std::array<double, coarse + 1> distance{};
    for (std::size_t i = 0; i <= coarse; ++i) {
        const double t = fixed_t >= 0 ? fixed_t : lines[i].nearest(q);
        distance[i] = (lines[i].start + t * lines[i].along - q).squaredNorm();
    }
    std::optional<Hit> best, facing;
    for (int i = 0; i <= coarse; ++i) {
        const auto k = std::size_t(i);
        if ((i > 0 && distance[k - 1] < distance[k]) ||
            (i < coarse && distance[k + 1] < distance[k])) {
            continue;
        }
        const Hit hit =
            descend(section, std::max(at(i - 1), -1.0), std::min(at(i + 1), 1.0), q, fixed_t);
        if (!best || hit.distance < best->distance) best = hit;
        if (side && normal_at(section, hit.s, hit.t).dot(*side) > 0 &&
            (!facing || hit.distance < facing->distance)) {
            facing = hit;
        }
    }
    return facing ? *facing : *best;
}

}  // namespace

NacaWing::NacaWing(WingSection section) : section_(section), arc_(steps + 1, 0.0) {
    // Simpson's rule on each step.
    const auto speed = [&](double s) { return std::hypot(2 * s, profile(section, s)[1]); };
    for (std::size_t i = 1; i <= steps; ++i) {
        const double a = 2.0 * double(i - 1) / steps - 1, b = 2.0 * double(i) / steps - 1;
        arc_[i] = arc_[i - 1] + (b - a) / 6 * (speed(a) + 4 * speed(0.5 * (a + b)) + speed(b));
    }
    const Vec3 at_root = point(1, 0, section), at_tip = point(1, 1, section);
    features_.curves.resize(3);
    features_.curves[0] = {
        geom::FeatureKind::Sharp, (at_tip - at_root).norm(), false, 0, 1, at_root, at_tip};
    for (int end = 0; end < 2; ++end) {
        const Vec3 corner = end == 0 ? at_root : at_tip;
        features_.curves[std::size_t(1 + end)] = {
            geom::FeatureKind::Free, arc_.back() * chord_at(end), true, end, end, corner, corner};
        features_.corners.push_back({corner, geom::CornerKind::Junction, {0, 1 + end, 1 + end}});
    }
}

geom::Box3 NacaWing::bounds() const {
    return {Vec3(0, 0, -0.061 * root), Vec3(std::max(root, sweep + tip), span, 0.061 * root)};
}

Vec3 NacaWing::point(double s, double t, WingSection section) {
    return derivatives(section, s, t).p;
}

geom::FootPoint NacaWing::foot_point(const Vec3& query, const std::optional<Vec3>& side) const {
    const Hit hit = nearest(section_, query, side, -1.0);
    return {point(hit.s, hit.t, section_),
            normal_at(section_, hit.s, hit.t),
            hit.distance,
            hit.s < 0 ? 0 : 1,
            {hit.s, hit.t}};
}

double NacaWing::parameter_at(double share) const {
    const double arc = std::clamp(share, 0.0, 1.0) * arc_.back();
    const auto above = std::upper_bound(arc_.begin(), arc_.end() - 1, arc);
    const auto i = std::max<std::ptrdiff_t>(above - arc_.begin(), 1);
    const double from = arc_[std::size_t(i - 1)], to = arc_[std::size_t(i)];
    return 2.0 * (double(i - 1) + (arc - from) / (to - from)) / steps - 1.0;
}

double NacaWing::share_at(double s) const {
    const double place = std::clamp(0.5 * (s + 1), 0.0, 1.0) * steps;
    const auto i = std::min(std::size_t(place), std::size_t(steps - 1));
    return (arc_[i] + (place - double(i)) * (arc_[i + 1] - arc_[i])) / arc_.back();
}

geom::FeaturePoint NacaWing::point_on_curve(int curve, double arc_length) const {
    const geom::FeatureCurve& c = features_.curves[std::size_t(curve)];
    if (curve == 0) {
        const Vec3 tangent = (c.end - c.start).normalized();
        return {c.start + std::clamp(arc_length, 0.0, c.length) * tangent, 0.0, 0, arc_length,
                tangent};
    }
    const double share = arc_length / c.length;
    const double s = parameter_at(share >= 0 && share <= 1 ? share : share - std::floor(share));
    const Derivatives d = derivatives(section_, s, curve - 1);
    return {d.p, 0.0, curve, arc_length, d.ds.normalized()};
}

geom::FeaturePoint NacaWing::nearest_on_curve(int curve, const Vec3& query,
                                              const std::optional<geom::ArcRange>& within) const {
    const geom::FeatureCurve& c = features_.curves[std::size_t(curve)];
    double arc = 0.0;
    Vec3 point = Vec3::Zero(), tangent = Vec3::Zero();
    if (curve == 0) {
        arc = std::clamp((query - c.start).dot(c.end - c.start) / c.length, 0.0, c.length);
    } else {
        // The exact point; its arc length to the accuracy of the table.
        const Hit hit = nearest(section_, query, std::nullopt, curve - 1);
        const Derivatives d = derivatives(section_, hit.s, curve - 1);
        arc = share_at(hit.s) * c.length;
        point = d.p;
        tangent = d.ds.normalized();
    }
    if (curve == 0 || (within && (arc < within->from || arc > within->to))) {
        if (within) arc = std::clamp(arc, within->from, within->to);
        const geom::FeaturePoint at = point_on_curve(curve, arc);
        point = at.point;
        tangent = at.tangent;
    }
    return {point, (point - query).norm(), curve, arc, tangent};
}

mesh::Cage naca_wing_cage(int around, int along, WingSection section) {
    std::vector<Vec3> points;
    for (int j = 0; j <= along; ++j) {
        for (int i = 0; i < around; ++i) {
            points.push_back(NacaWing::point(2.0 * i / around - 1.0, double(j) / along, section));
        }
    }
    std::vector<std::vector<int>> faces;
    mesh::TopologyInput tags;
    const auto at = [&](int i, int j) { return j * around + i % around; };
    for (int j = 0; j < along; ++j) {
        for (int i = 0; i < around; ++i) {
            faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
        tags.creases.push_back({at(0, j), at(0, j + 1), mesh::infinite_sharpness});
    }
    tags.boundary_rule = mesh::BoundaryRule::EdgeOnly;
    return make_cage(points, faces, std::move(tags));
}

}  // namespace patchwright::test
