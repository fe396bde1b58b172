#include "measure/limit_search.h"
#include "support/cages.h"

#include <patchwright/fit/fit.h>

#include <catch2/catch.hpp>

using namespace patchwright;
using geom::Vec3;

namespace {

/// A plane with a ridge along y that is much narrower than faces: the feet of nearly all points
/// near the plane are on the plane.
class Blade final : public geom::ReferenceSurface {
  public:
    Blade(double half_width, double height) : half_width_(half_width), height_(height) {}
    geom::Box3 bounds() const override { return {Vec3(-1, -1, 0), Vec3(1, 1, height_)}; }
    geom::FootPoint foot_point(const Vec3& q, const std::optional<Vec3>&) const override {
        geom::FootPoint best;
        best.distance = 1e300;
        const std::array<Eigen::Vector2d, 5> line{
            {{-1.0, 0.0}, {-half_width_, 0.0}, {0.0, height_}, {half_width_, 0.0}, {1.0, 0.0}}};
        for (std::size_t i = 0; i + 1 < line.size(); ++i) {
            const Eigen::Vector2d way = line[i + 1] - line[i];
            const double t = std::clamp(
                (Eigen::Vector2d(q.x(), q.z()) - line[i]).dot(way) / way.squaredNorm(), 0.0, 1.0);
            const Eigen::Vector2d at = line[i] + t * way;
            const Vec3 p(at.x(), std::clamp(q.y(), -1.0, 1.0), at.y());
            if ((p - q).norm() < best.distance)
                best = {p, Vec3(-way.y(), 0, way.x()).normalized(), (p - q).norm(), 0};
        }
        return best;
    }
    std::vector<geom::SurfaceSample> sample(int count) const override {
        std::vector<geom::SurfaceSample> samples;
        const int n = int(std::sqrt(double(count)));
        for (int i = 0; i <= n; ++i) {
            for (int j = 0; j <= n; ++j) {
                const double x = -1.0 + 2.0 * i / n;
                const double z = std::max(0.0, height_ * (1.0 - std::abs(x) / half_width_));
                samples.push_back({Vec3(x, -1.0 + 2.0 * j / n, z), Vec3::UnitZ(), 0, 1.0});
            }
        }
        return samples;
    }

  private:
    double half_width_, height_;
};

mesh::Cage plate() {
    mesh::Cage cage = test::grid(5, 3, {.boundary_rule = mesh::BoundaryRule::EdgeAndCorner});
    cage.points.col(0) = cage.points.col(0).array() * 0.4 - 1.0;
    cage.points.col(1) = cage.points.col(1).array() * (2.0 / 3.0) - 1.0;
    return cage;
}

}  // namespace

TEST_CASE("a fit does not take for met what it does not cover", "[fit][oracle]") {
    const Blade blade(0.02, 0.05);
    fit::FitOptions options{.tolerance_mm = 0.01, .max_levels = 0, .reverse_samples = 0};
    const auto one_way = fit::fit(plate(), blade, options);
    CHECK(one_way.within_tolerance);  // flat: its points are near the plane
    options.reverse_samples = 40000;
    const auto both = fit::fit(plate(), blade, options);
    CHECK_FALSE(both.within_tolerance);
    CHECK(both.levels[0].reverse_max_mm > 0.02);
    CHECK(both.levels[0].reverse_max_mm <= 0.05 + 1e-6);
}

TEST_CASE("a fit goes where it is not near the reference", "[fit][oracle]") {
    const Blade ridge(0.2, 0.2);
    const auto fitted = [&](int reverse_samples) {
        return fit::fit(plate(), ridge, {.tolerance_mm = 0.02, .reverse_samples = reverse_samples});
    };
    const auto both = fitted(10000);
    CHECK(both.within_tolerance);
    // Measured independently of the fit.
    std::vector<Vec3> points;
    for (const auto& s : ridge.sample(3000)) points.push_back(s.point);
    const auto farthest = [&](const mesh::Cage& cage) {
        double most = 0.0;
        for (const auto& near : measure::LimitSearch(cage.topology).nearest(cage.points, points))
            most = std::max(most, near.distance);
        return most;
    };
    CHECK(farthest(both.cage) <= 0.02);
}
