#include "fit/match/path_alignment.h"
#include "support/cages.h"

#include <patchwright/fit/fit.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace patchwright;
using geom::Vec3;

namespace {

/// A ribbon between two long lines that a half circle joins, as the trailing edge of a wing that is
/// round at its tip: one free curve from corner to corner, whose sides are near each other.
class Ribbon final : public geom::ReferenceSurface {
  public:
    static constexpr double length = 1000.0, radius = 1.0;

    Ribbon() {
        geom::FeatureCurve curve;
        curve.kind = geom::FeatureKind::Free;
        curve.length = 2.0 * length + M_PI * radius;
        curve.start_corner = 0;
        curve.end_corner = 1;
        curve.start = at(0.0);
        curve.end = at(curve.length);
        features_.curves.push_back(curve);
        for (const Vec3& p : {curve.start, curve.end})
            features_.corners.push_back({p, geom::CornerKind::Junction, {0}});
    }
    static Vec3 at(double s) {
        const double turn = (s - length) / radius;
        if (turn < 0.0) return {s, -radius, 0.0};
        if (turn > M_PI) return {2.0 * length + M_PI * radius - s, radius, 0.0};
        return {length + radius * std::sin(turn), -radius * std::cos(turn), 0.0};
    }
    geom::Box3 bounds() const override {
        return {Vec3(0, -radius, 0), Vec3(length + radius, radius, 0)};
    }
    geom::FootPoint foot_point(const Vec3& q, const std::optional<Vec3>&) const override {
        return {Vec3(q.x(), q.y(), 0.0), Vec3::UnitZ(), std::abs(q.z()), 0};
    }
    const geom::Features& features() const override { return features_; }
    geom::FeaturePoint nearest_on_curve(
        int, const Vec3& q, const std::optional<geom::ArcRange>& within) const override {
        const double whole = features_.curves[0].length;
        const double turn = std::atan2(q.x() - length, -q.y());
        geom::FeaturePoint best;
        best.distance = std::numeric_limits<double>::infinity();
        const double from = within ? within->from : 0.0, to = within ? within->to : whole;
        for (const double s : {q.x(), length + radius * turn, whole - q.x(), from, to}) {
            geom::FeaturePoint hit = point_on_curve(0, std::clamp(s, from, to));
            hit.distance = (hit.point - q).norm();
            if (hit.distance < best.distance) best = hit;
        }
        return best;
    }
    geom::FeaturePoint point_on_curve(int, double s) const override {
        constexpr double step = 1e-6;
        return {at(s), 0.0, 0, s, (at(s + step) - at(s - step)).normalized()};
    }

  private:
    geom::Features features_;
};

/// Points all along its curve, denser where it turns.
std::vector<double> arc_lengths() {
    std::vector<double> arcs;
    for (double s = 0.0; s < Ribbon::length; s += 40.0) arcs.push_back(s);
    for (int k = 0; k <= 8; ++k) arcs.push_back(Ribbon::length + M_PI * Ribbon::radius * k / 8);
    for (double s = 40.0; s <= Ribbon::length; s += 40.0)
        arcs.push_back(Ribbon::length + M_PI * Ribbon::radius + s);
    return arcs;
}

}  // namespace

TEST_CASE("points of a chain keep their side of a narrow path however far it is moved",
          "[fit][features]") {
    const Ribbon ribbon;
    const std::vector<double> arcs = arc_lengths();
    const fit::PathAlignment alignment(ribbon, {{0, {0.0, ribbon.features().curves[0].length}}},
                                       false, arcs.size());
    for (const double amount : {0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0}) {
        for (const Vec3& way : {Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(1, 1, 0)}) {
            geom::Polyline chain;
            for (const double s : arcs)
                chain.emplace_back(Ribbon::at(s) + amount * Ribbon::at(s).x() / 1e3 * way);
            const auto targets = alignment.targets(chain);
            double off = 0.0;
            for (std::size_t i = 0; i < arcs.size(); ++i)
                off = std::max(off, std::abs(targets[i].arc_length - arcs[i]));
            // By little more than it was moved; the other side is as far as the tip, twice.
            INFO("moved by " << amount * way.transpose());
            CHECK(off <= 2.0 * amount + 1e-6);
        }
    }
}

TEST_CASE("points of a chain keep their side however few places the path has near them",
          "[fit][features]") {
    const Ribbon ribbon;
    const double whole = ribbon.features().curves[0].length;
    // Between the round end and the next place along a straight side lie up to 100 mm.
    for (const int count : {10, 11, 12, 13, 17, 23, 31, 40}) {
        const fit::PathAlignment alignment(ribbon, {{0, {0.0, whole}}}, false, std::size_t(count));
        std::vector<double> arcs;
        for (int i = 0; i < count; ++i) arcs.push_back(whole * (i + 0.5) / count);
        for (const double before : {30.0, 20.0, 10.0, 5.0}) arcs.push_back(Ribbon::length - before);
        std::sort(arcs.begin(), arcs.end());
        geom::Polyline chain;
        for (const double s : arcs) chain.push_back(Ribbon::at(s));
        const auto targets = alignment.targets(chain);
        double off = 0.0;
        for (std::size_t i = 0; i < arcs.size(); ++i)
            off = std::max(off, std::abs(targets[i].arc_length - arcs[i]));
        INFO(count << " points");
        CHECK(off <= 1e-6);
    }
}
