#include <patchwright/adapt/sensor.h>
#include <patchwright/adapt/size_field.h>
#include <patchwright/base/error.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

namespace patchwright {
namespace {

using adapt::Sensor;
using geom::Vec3;

/// Values of f at points.
template <class Function>
Sensor sensor_of(const geom::Points& points, const Function& f) {
    std::vector<double> values;
    for (Eigen::Index i = 0; i < points.rows(); ++i) values.push_back(f(points.row(i).transpose()));
    return {points, std::move(values)};
}

TEST_CASE("a linear quantity is reconstructed exactly between points", "[adapt][oracle]") {
    const auto f = [](const Vec3& p) { return 3.0 * p.x() - 2.0 * p.y() + 0.5 * p.z() + 7.0; };
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    // On a plane, and in space.
    for (const double depth : {0.0, 1.0}) {
        geom::Points points(3000, 3);
        for (Eigen::Index i = 0; i < points.rows(); ++i)
            points.row(i) << unit(random), unit(random), depth * unit(random);
        const Sensor sensor = sensor_of(points, f);
        double sum = 0.0;
        for (int k = 0; k < 500; ++k) {
            const Vec3 p{0.2 + 0.6 * unit(random), 0.2 + 0.6 * unit(random),
                         depth * (0.2 + 0.6 * unit(random))};
            sum += std::abs(sensor(p) - f(p));
        }
        // The bounds of the neighbours cut off some of the slope where they lie on one side.
        // Between points 1/sqrt(3000) or 1/cbrt(3000) apart the quantity changes by 0.07 and 0.25.
        CHECK(sum / 500.0 <= (depth == 0.0 ? 0.07 : 0.25) / 10.0);
        CHECK(sensor.range() <= 5.5);
    }
    // On a grid no bound acts: exact, stretched as well.
    for (const double aspect : {1.0, 10.0, 1000.0}) {
        geom::Points points(40 * 40, 3);
        for (int i = 0; i < 40; ++i)
            for (int j = 0; j < 40; ++j) points.row(40 * i + j) << i / aspect, j, 0.0;
        const Sensor sensor = sensor_of(points, f);
        for (int k = 0; k < 500; ++k) {
            const Vec3 p{(2.0 + 35.0 * unit(random)) / aspect, 2.0 + 35.0 * unit(random), 0.0};
            CHECK(sensor(p) == Approx(f(p)).margin(1e-9));
        }
    }
}

TEST_CASE("a quantity's reconstruction has second order on a sphere", "[adapt][oracle]") {
    const auto f = [](const Vec3& p) { return std::sin(2.0 * p.x()) * p.y() + p.z(); };
    const auto on_sphere = [](double u, double v) {
        return Vec3(std::cos(u) * std::sin(v), std::sin(u) * std::sin(v), std::cos(v));
    };
    std::vector<double> errors;
    for (const int n : {20, 40, 80}) {
        geom::Points points(Eigen::Index(2 * n) * n, 3);
        for (int i = 0; i < 2 * n; ++i)
            for (int j = 0; j < n; ++j)
                points.row(i * n + j) = on_sphere(M_PI * i / n, M_PI * (j + 0.5) / n).transpose();
        const Sensor sensor = sensor_of(points, f);
        double sum = 0.0;
        int count = 0;
        for (int k = 0; k < 2000; ++k, ++count) {
            const Vec3 p = on_sphere(2.39996 * k, std::acos(1.0 - (2.0 * k + 1.0) / 2000.0));
            sum += std::abs(sensor(p) - f(p));
        }
        errors.push_back(sum / count);
    }
    // Of order 2 where slopes are good to first order; nearest values alone have 1.
    CHECK(errors[0] / errors[1] > 3.0);
    CHECK(errors[1] / errors[2] > 3.0);
}

TEST_CASE("values stay within those around, and what few points do not tell has no slope",
          "[adapt]") {
    geom::Points points(50, 3);
    for (int i = 0; i < 50; ++i) points.row(i) << i, 0.0, 0.0;  // along one line
    const Sensor step = sensor_of(points, [](const Vec3& p) { return p.x() < 24.5 ? 1.0 : 2.0; });
    for (double x = -10.0; x < 60.0; x += 0.37) {
        const double value = step({x, 3.0, -2.0});
        CHECK(value >= 1.0);
        CHECK(value <= 2.0);
        if (x < 20.5) CHECK(value == 1.0);
        if (x > 28.5) CHECK(value == 2.0);
    }
    geom::Points one(1, 3);
    one << 1.0, 2.0, 3.0;
    CHECK(Sensor(one, {4.0})(Vec3::Zero()) == 4.0);
    CHECK(Sensor(one, {4.0}).range() == 0.0);
    geom::Points twice(4, 3);  // points of two blocks
    twice << 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0;
    CHECK(Sensor(twice, {0.0, 0.0, 1.0, 1.0})({0.25, 0.0, 0.0}) == Approx(0.25));
    CHECK_THROWS_AS(Sensor(one, {1.0, 2.0}), base::InvalidArgument);
    CHECK_THROWS_AS(Sensor(one, {std::nan("")}), base::InvalidArgument);
    CHECK_THROWS_AS(Sensor(geom::Points(0, 3), {}), base::InvalidArgument);
    CHECK_THROWS_AS(adapt::SizeField(one, {0.0}), base::InvalidArgument);
    CHECK_THROWS_AS(adapt::SizeField(one, {1.0, 1.0}), base::InvalidArgument);
}

}  // namespace
}  // namespace patchwright
