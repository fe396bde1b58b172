#include "measure/second_order.h"

#include <patchwright/base/error.h>
#include <patchwright/measure/deviation.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <atomic>

using namespace patchwright;
using geom::Vec3;
using measure::ShapePair;
using measure::SurfaceShape;

namespace {

/// Counts the foot points that are asked for; pieces are a grid of 2 n^2 triangles over the unit
/// square of parameters.
class Counted : public geom::ModelSurface {
  public:
    explicit Counted(int n) : n_(n) {}
    geom::Box3 bounds() const override {
        geom::Box3 box;
        for (const geom::SurfacePiece& piece : pieces())
            for (const auto& uv : piece.uv) box.add(point_on_face(0, uv).point);
        return box;
    }
    geom::FootPoint foot_point(const Vec3& q, const std::optional<Vec3>&) const override {
        ++asked;
        return nearest(q);
    }
    std::optional<geom::Curvature> curvature(const geom::FootPoint& at) const override {
        return curvature_at(at);
    }
    std::optional<geom::FeaturePoint> feature_point(const Vec3&, geom::FeatureKind) const override {
        return std::nullopt;
    }
    std::vector<geom::SurfaceSample> sample(int) const override { return {}; }
    geom::SurfaceMesh surface_mesh(double) const override { return {}; }
    std::vector<std::string> face_names() const override { return {""}; }
    bool has_cad_faces() const override { return false; }
    std::vector<geom::SurfacePiece> pieces() const override {
        std::vector<geom::SurfacePiece> result;
        const auto at = [&](int i, int j) {
            return Eigen::Vector2d(double(i) / n_, double(j) / n_);
        };
        for (int i = 0; i < n_; ++i) {
            for (int j = 0; j < n_; ++j) {
                result.push_back({0, {at(i, j), at(i + 1, j), at(i + 1, j + 1)}});
                result.push_back({0, {at(i, j), at(i + 1, j + 1), at(i, j + 1)}});
            }
        }
        return result;
    }

    mutable std::atomic<int> asked{0};

  protected:
    virtual geom::FootPoint nearest(const Vec3& q) const = 0;
    virtual std::optional<geom::Curvature> curvature_at(const geom::FootPoint& at) const = 0;

  private:
    int n_;
};

/// A belt around the equator.
class Ball final : public Counted {
  public:
    Ball(double radius, int n) : Counted(n), radius_(radius) {}
    geom::FootPoint point_on_face(int, const Eigen::Vector2d& uv) const override {
        const double angle = 2.0 * M_PI * uv[0], height = uv[1] - 0.5;
        const Vec3 n(std::cos(height) * std::cos(angle), std::cos(height) * std::sin(angle),
                     std::sin(height));
        return {radius_ * n, n, 0.0, 0, uv};
    }

  protected:
    geom::FootPoint nearest(const Vec3& q) const override {
        const Vec3 n = q.normalized();
        return {radius_ * n, n, std::abs(q.norm() - radius_), 0};
    }
    std::optional<geom::Curvature> curvature_at(const geom::FootPoint& at) const override {
        const Vec3 x = at.normal.unitOrthogonal();
        return geom::Curvature{{-1.0 / radius_, -1.0 / radius_}, {x, at.normal.cross(x)}};
    }

  private:
    double radius_;
};

/// z = height exp(-(x^2 + y^2) / width^2) over the square of side 2 around a centre, as a surface;
/// feet are those on the plane z = 0.
class Bump final : public Counted {
  public:
    Bump(double height, double width, int n) : Counted(n), height_(height), width_(width) {}
    geom::FootPoint point_on_face(int, const Eigen::Vector2d& uv) const override {
        const double x = 2.0 * uv[0] - 1.03, y = 2.0 * uv[1] - 0.96;
        const double z = height_ * std::exp(-(x * x + y * y) / (width_ * width_));
        const double slope = -2.0 * z / (width_ * width_);
        return {Vec3(x, y, z), Vec3(-slope * x, -slope * y, 1.0).normalized(), 0.0, 0, uv};
    }

  protected:
    geom::FootPoint nearest(const Vec3& q) const override {
        return {Vec3(q.x(), q.y(), 0.0), Vec3::UnitZ(), std::abs(q.z()), 0};
    }
    /// Of a surface of revolution: along the meridian and around the axis.
    std::optional<geom::Curvature> curvature_at(const geom::FootPoint& at) const override {
        const double r = std::hypot(at.point.x(), at.point.y()), w2 = width_ * width_;
        const double z = at.point.z(), first = -2.0 * r * z / w2;
        const double second = z * (4.0 * r * r / (w2 * w2) - 2.0 / w2);
        const double root = std::sqrt(1.0 + first * first);
        const double meridian = second / (root * root * root);
        const double around = r > 1e-9 ? first / (r * root) : meridian;
        const Vec3 out = r > 1e-9 ? Vec3(at.point.x() / r, at.point.y() / r, 0.0) : Vec3::UnitX();
        const Vec3 along = (out + first * Vec3::UnitZ()).normalized();
        const Vec3 across = Vec3::UnitZ().cross(out);
        if (meridian < around) return geom::Curvature{{meridian, around}, {along, across}};
        return geom::Curvature{{around, meridian}, {across, along}};
    }

  private:
    double height_, width_;
};

/// The unit square, but for one corner, which lies at height 1.
class LooseCorner final : public Counted {
  public:
    LooseCorner() : Counted(4) {}
    geom::FootPoint point_on_face(int, const Eigen::Vector2d& uv) const override {
        return {Vec3(uv[0], uv[1], uv == Eigen::Vector2d(1.0, 1.0) ? 1.0 : 0.0), Vec3::UnitZ(), 0.0,
                0, uv};
    }

  protected:
    geom::FootPoint nearest(const Vec3& q) const override {
        return {Vec3(q.x(), q.y(), 0.0), Vec3::UnitZ(), std::abs(q.z()), 0};
    }
    std::optional<geom::Curvature> curvature_at(const geom::FootPoint&) const override {
        return std::nullopt;
    }
};

geom::Curvature round_shape(double radius, const Vec3& normal) {
    const Vec3 x = normal.unitOrthogonal();
    return {{-1.0 / radius, -1.0 / radius}, {x, normal.cross(x)}};
}

/// Corners of an equilateral triangle at this angle from the z axis.
std::array<Vec3, 3> directions(double angle) {
    std::array<Vec3, 3> result;
    for (std::size_t k = 0; k < 3; ++k) {
        const double turn = 2.0 * M_PI * double(k) / 3.0;
        result[k] = Vec3(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn),
                         std::cos(angle));
    }
    return result;
}

double error_of(const std::array<ShapePair, 3>& p) {
    const auto error = measure::interpolation_error({&p[0], &p[1], &p[2]});
    REQUIRE(error.has_value());
    return *error;
}

}  // namespace

TEST_CASE("between corners on two spheres their heights differ", "[measure][oracle]") {
    const double large = 10.5, small = 10.0, angle = GENERATE(0.02, 0.1, 0.2);
    std::array<ShapePair, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 n = directions(angle)[k];
        p[k] = {{large * n, n, round_shape(large, n)}, {small * n, n, round_shape(small, n)}};
        CHECK(p[k].distance() == Approx(large - small));
    }
    // At the middle, where the heights are largest: r (1 - cos angle).
    const double exact = (large - small) * (1.0 - std::cos(angle));
    CHECK(error_of(p) >= (1.0 - 0.3 * angle * angle) * exact);  // an arc is above its parabola
    CHECK(error_of(p) <= 1.05 * exact);
    // The same surface: nothing lies between.
    for (ShapePair& pair : p) pair.foot = pair.point;
    CHECK(error_of(p) < 1e-14);
}

TEST_CASE("between corners on a sphere and a plane the sphere's height counts",
          "[measure][oracle]") {
    const double radius = 4.0, angle = GENERATE(0.02, 0.1, 0.2);
    std::array<ShapePair, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 n = directions(angle)[k];
        const Vec3 foot(radius * n.x(), radius * n.y(), 5.0);
        p[k] = {{radius * n, n, round_shape(radius, n)},
                {foot, Vec3::UnitZ(), geom::Curvature{{0, 0}, {Vec3::UnitX(), Vec3::UnitY()}}}};
    }
    const double exact = radius * (1.0 - std::cos(angle));
    CHECK(error_of(p) >= (1.0 - 0.3 * angle * angle) * exact);  // an arc is above its parabola
    CHECK(error_of(p) <= 1.05 * exact);
    p[1].foot.curvature.reset();
    CHECK_FALSE(measure::interpolation_error({&p[0], &p[1], &p[2]}).has_value());
}

TEST_CASE("a right angle between feet is as far off as its tangent planes", "[measure][oracle]") {
    // Feet on both sides of the edge along y at x = z = 0, points 0.1 off them.
    const auto flat = [](const Vec3& n) {
        const Vec3 x = n.unitOrthogonal();
        return geom::Curvature{{0, 0}, {x, n.cross(x)}};
    };
    const auto pair = [&](const Vec3& foot, const Vec3& n) {
        const Vec3 up = Vec3(1, 0, 1).normalized();
        return ShapePair{{foot + 0.1 * n, up, flat(up)}, {foot, n, flat(n)}};
    };
    const std::array<ShapePair, 3> p{pair({-1, 0, 0}, Vec3::UnitZ()),
                                     pair({-1, 1, 0}, Vec3::UnitZ()),
                                     pair({0, 0, -1}, Vec3::UnitX())};
    // The middle of the chord between (-1, 0, 0) and (0, 0, -1) is 0.5 below both planes.
    CHECK(error_of(p) >= 0.5);
}

TEST_CASE("the bound of two spheres is their distance", "[measure][oracle]") {
    const Ball small(10.0, 12), large(10.25, 12);
    for (const auto& [from, to] : {std::pair(&small, &large), std::pair(&large, &small)}) {
        const double bound = measure::measure_bound(*from, *to, {.found_mm = 0.25});
        CHECK(bound >= 0.25);
        CHECK(bound <= 1.1 * 0.25);
    }
    CHECK(measure::measure_bound(small, small) <= 1e-5 * small.bounds().diagonal());
    CHECK_THROWS_AS(measure::measure_bound(small, large, {.foot_points = -1}),
                    base::InvalidArgument);
    CHECK_THROWS_AS(measure::measure_bound(
                        small, large, {.progress = [](std::string_view, double) { return false; }}),
                    base::Cancelled);
}

TEST_CASE("the bound holds a bump between samples", "[measure][oracle]") {
    // Corners and middles are up to 0.1 from the top of a bump 0.2 wide.
    const double height = 0.05;
    const Bump bump(height, 0.2, 8);
    const double bound = measure::measure_bound(bump, bump);
    CHECK(bound >= height);
    CHECK(bound <= 1.11 * height);
    CHECK(bump.asked < 2000);
    // With a budget that does not go beyond the first pieces it is looser, but still a bound.
    const Bump again(height, 0.2, 8);
    const double coarse = measure::measure_bound(again, again, {.foot_points = 0});
    CHECK(coarse >= height);
    CHECK(again.asked == 81 + 128);
    // More foot points, a better bound.
    const double middle = measure::measure_bound(again, again, {.foot_points = 200});
    CHECK(middle <= coarse);
    CHECK(bound <= middle);
}

TEST_CASE("where a surface jumps the bound ends between neighbouring numbers", "[measure]") {
    const LooseCorner square;
    const double bound = measure::measure_bound(square, square);
    CHECK(bound >= 1.0);
    CHECK(bound <= 1.0 + 0.6 * 1.01);  // the corner's distance and the reach of triangles beside it
}
