#include "occ/shapes.h"

#include <patchwright/base/error.h>
#include <patchwright/measure/relative_fairness.h>

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <Geom_BezierSurface.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <catch2/catch.hpp>

#include <functional>

using namespace patchwright;
using measure::RelativeFairness;
using occ::CadReference;

namespace {

CadReference reference_of(const TopoDS_Shape& shape) { return CadReference(test::model_of(shape)); }

/// The graph of a cubic of x over the square from -10 to 10.
CadReference graph(const std::function<double(double)>& cubic) {
    // Blossoms: the control values of a cubic on an interval from its values and end slopes.
    const double h = 1e-6, third = 20.0 / 3.0;
    const double first = cubic(-10.0), last = cubic(10.0);
    const double up = (cubic(-10.0 + h) - cubic(-10.0 - h)) / (2 * h);
    const double down = (cubic(10.0 + h) - cubic(10.0 - h)) / (2 * h);
    const double z[] = {first, first + third * up, last - third * down, last};
    TColgp_Array2OfPnt poles(1, 4, 1, 2);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 2; ++j)
            poles.SetValue(i + 1, j + 1, gp_Pnt(-10.0 + third * i, -10.0 + 20.0 * j, z[i]));
    const Handle(Geom_BezierSurface) surface = new Geom_BezierSurface(poles);
    return reference_of(BRepBuilderAPI_MakeFace(surface, 1e-7).Face());
}

}  // namespace

TEST_CASE("concentric spheres have one normal, and curvatures that differ by known values",
          "[occ][oracle]") {
    const CadReference small = reference_of(BRepPrimAPI_MakeSphere(10.0).Shape());
    const CadReference large = reference_of(BRepPrimAPI_MakeSphere(10.25).Shape());
    const RelativeFairness f =
        measure::measure_relative_fairness(small, large, {.samples = 1000, .lines = 10});
    CHECK(f.samples > 990);  // but for what is beside poles
    CHECK(f.left_out == 0);
    CHECK(f.normal_angle_rad.max < 1e-6);
    const double diagonal = large.bounds().diagonal(), difference = 1.0 / 10.0 - 1.0 / 10.25;
    for (const double value : {f.curvature_difference.rms, f.curvature_difference.p50,
                               f.curvature_difference.p99, f.curvature_difference.max})
        CHECK(value == Approx(diagonal * difference).epsilon(1e-6));
    CHECK(f.inflections == 0);
    CHECK(f.extra_inflections == 0);
}

TEST_CASE("slopes of a graph are the angles between its normals and a plane's", "[occ][oracle]") {
    const CadReference plane = graph([](double) { return 0.0; });
    const CadReference tilted = graph([](double x) { return 0.01 * x; });
    const RelativeFairness f = measure::measure_relative_fairness(tilted, plane, {.samples = 500});
    CHECK(f.normal_angle_rad.rms == Approx(std::atan(0.01)));
    CHECK(f.normal_angle_rad.max == Approx(std::atan(0.01)));
    CHECK(f.curvature_difference.max < 1e-6);
    // Rows as wide as 0.002 of the diagonal along four sides are left out.
    const double row = 2e-3 * plane.bounds().diagonal() / 20.0;
    CHECK(f.left_out == Approx(500 * (1.0 - std::pow(1.0 - 2.0 * row, 2))).margin(5));
}

TEST_CASE("an inflection of the input is none that the output adds", "[occ][oracle]") {
    const CadReference plane = graph([](double) { return 0.0; });
    const CadReference wave = graph([](double x) { return 2e-4 * x * (x * x - 60.0); });
    const auto figures = [](const CadReference& output, const CadReference& input) {
        return measure::measure_relative_fairness(output, input, {.samples = 100, .lines = 40});
    };
    const RelativeFairness added = figures(wave, plane);
    CHECK(added.lines == 40);
    CHECK(added.inflections == 0);
    CHECK(added.extra_inflections == 20);  // half of the lines run along x, and pass 0 once
    const RelativeFairness kept = figures(wave, wave);
    CHECK(kept.inflections == 20);
    CHECK(kept.extra_inflections == 0);
    CHECK(kept.curvature_difference.max < 1e-9);
    CHECK(figures(plane, wave).extra_inflections == -20);
}

TEST_CASE("what is beside edges of the input, or far from it, does not count", "[occ][oracle]") {
    const CadReference box = reference_of(BRepPrimAPI_MakeBox(10.0, 10.0, 10.0).Shape());
    const RelativeFairness itself = measure::measure_relative_fairness(box, box, {.samples = 2000});
    const double row = 2e-3 * box.bounds().diagonal() / 10.0;
    CHECK(itself.left_out == Approx(2000 * (1.0 - std::pow(1.0 - 2.0 * row, 2))).margin(10));
    CHECK(itself.samples + itself.left_out == 2000);
    CHECK(itself.normal_angle_rad.max < 1e-9);
    const CadReference far =
        reference_of(BRepPrimAPI_MakeBox(gp_Pnt(100, 0, 0), gp_Pnt(110, 10, 10)).Shape());
    const RelativeFairness apart = measure::measure_relative_fairness(far, box, {.samples = 100});
    CHECK(apart.unmatched == 100);
    CHECK(apart.samples == 0);
    CHECK_THROWS_AS(measure::measure_relative_fairness(box, box, {.samples = 0}),
                    base::InvalidArgument);
}
