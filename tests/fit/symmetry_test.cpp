#include "support/analytic_references.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/fit.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

using namespace patchwright;
using geom::Vec3;

namespace {

/// Half of an ellipsoid, y >= 0, open at y = 0 (or moved along y: then there is no plane).
class HalfEllipsoid final : public geom::ReferenceSurface {
  public:
    explicit HalfEllipsoid(double shift = 0.0) : shift_(shift) {
        features_.curves.push_back({geom::FeatureKind::Free, 2 * M_PI, true});
    }
    geom::Box3 bounds() const override {
        return {Vec3(-radii.x(), shift_, -radii.z()),
                Vec3(radii.x(), shift_ + radii.y(), radii.z())};
    }
    geom::FootPoint foot_point(const Vec3& query, const std::optional<Vec3>&) const override {
        const Vec3 q = query - shift_ * Vec3::UnitY();
        const Vec3 squares = radii.cwiseProduct(radii);
        const auto inside = [&](double t) {
            return q.cwiseProduct(radii).cwiseQuotient(squares + Vec3::Constant(t)).squaredNorm() -
                   1.0;
        };
        double low = -squares.minCoeff() * (1 - 1e-9), high = 100.0;
        for (int i = 0; i < 200; ++i) {
            const double t = 0.5 * (low + high);
            (inside(t) > 0.0 ? low : high) = t;
        }
        Vec3 p = q.cwiseProduct(squares).cwiseQuotient(squares + Vec3::Constant(low));
        if (p.y() < 0.0) p = on_rim(std::atan2(q.z() / radii.z(), q.x() / radii.x()));
        const Vec3 n = p.cwiseQuotient(squares).normalized();
        p.y() += shift_;
        return {p, n, (query - p).norm(), 0};
    }
    const geom::Features& features() const override { return features_; }
    geom::FeaturePoint nearest_on_curve(int, const Vec3& q,
                                        const std::optional<geom::ArcRange>&) const override {
        double s = std::atan2(q.z() / radii.z(), q.x() / radii.x());
        for (int i = 0; i < 50; ++i) {
            const Vec3 r = on_rim(s) - q, d = tangent(s);
            s -= std::clamp(r.dot(d) / d.squaredNorm(), -0.2, 0.2);
        }
        geom::FeaturePoint hit = point_on_curve(0, s);
        hit.distance = (hit.point - q).norm();
        return hit;
    }
    geom::FeaturePoint point_on_curve(int, double s) const override {
        return {on_rim(s) + shift_ * Vec3::UnitY(), 0.0, 0, s, tangent(s).normalized()};
    }

  private:
    static Vec3 on_rim(double s) { return {radii.x() * std::cos(s), 0, radii.z() * std::sin(s)}; }
    static Vec3 tangent(double s) { return {-radii.x() * std::sin(s), 0, radii.z() * std::cos(s)}; }
    static inline const Vec3 radii{2.0, 1.2, 0.8};
    double shift_;
    geom::Features features_;
};

/// The upper half of a box, open below, somewhat off.
mesh::Cage half_box() {
    std::vector<Vec3> points;
    for (int i = 0; i < 8; ++i) {
        points.emplace_back(1.5 * (2 * (i & 1) - 1), i >> 1 & 1 ? 1.3 : 0.05,
                            0.6 * (2 * (i >> 2) - 1));
    }
    std::vector<std::vector<int>> faces;
    for (const auto& face : test::cube_faces) {
        if (face != std::vector<int>{0, 1, 5, 4}) faces.push_back(face);
    }
    return subd::refine(test::make_cage(points, faces), 1);
}

double largest_tilt(const mesh::Cage& cage) {
    const subd::LimitEvaluator evaluator(cage.topology);
    const mesh::Topology& t = *cage.topology;
    double tilt = 0.0;
    for (const mesh::EdgeId e : t.edges()) {
        if (!t.is_boundary(e)) continue;
        const mesh::CornerId c = t.corner(e);
        const int side = c.value - t.corners(t.face(c))[0].value;
        for (const double s : {0.0, 0.3, 0.71}) {
            const double u[4] = {s, 1, 1 - s, 0}, v[4] = {0, s, 1, 1 - s};
            const auto p = evaluator.evaluate(cage.points, {t.face(c), u[side], v[side]}, 1);
            tilt = std::max(tilt, std::abs(p.normal.y()));
            CHECK(std::abs(p.position.y()) < 1e-15);
        }
    }
    return tilt;
}

}  // namespace

TEST_CASE("half an ellipsoid ends on its symmetry plane at right angles", "[fit][oracle]") {
    const auto result = fit::fit(half_box(), HalfEllipsoid(), {.tolerance_mm = 2e-3});
    CHECK(result.within_tolerance);
    CHECK(result.symmetry_axis == 1);
    CHECK(largest_tilt(result.cage) < 1e-12);
    // Asked for it is the same.
    const auto asked =
        fit::fit(half_box(), HalfEllipsoid(), {.tolerance_mm = 2e-3, .symmetry = fit::Symmetry::Y});
    CHECK(asked.cage.points == result.cage.points);
    // With runouts at the border as well.
    const auto runouts =
        fit::fit(half_box(), HalfEllipsoid(),
                 {.tolerance_mm = 2e-4, .crease_rule = mesh::CreaseRule::ParabolicRunout});
    CHECK(runouts.within_tolerance);
    CHECK(runouts.cage.topology->has_runouts());
    CHECK(largest_tilt(runouts.cage) < 1e-12);
}

TEST_CASE("no plane is kept where there is none, or none is wanted", "[fit]") {
    const auto none = fit::fit(half_box(), HalfEllipsoid(),
                               {.tolerance_mm = 1e-2, .symmetry = fit::Symmetry::None});
    CHECK_FALSE(none.symmetry_axis);
    mesh::Cage moved = half_box();
    moved.points.col(1).array() += 0.5;
    CHECK_FALSE(fit::fit(moved, HalfEllipsoid(0.5), {.tolerance_mm = 1e-2}).symmetry_axis);
    CHECK_THROWS_AS(
        fit::fit(half_box(), HalfEllipsoid(), {.tolerance_mm = 1e-2, .symmetry = fit::Symmetry::X}),
        base::InvalidArgument);
}
