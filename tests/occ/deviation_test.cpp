#include "occ/shapes.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/occ/deviation.h>

#include <BRepPrimAPI_MakeSphere.hxx>
#include <catch2/catch.hpp>

using namespace patchwright;
using fit::Deviation;
using geom::Vec3;
using occ::CadReference;

namespace {

CadReference sphere(double radius) {
    return CadReference(test::model_of(BRepPrimAPI_MakeSphere(radius).Shape()));
}

}  // namespace

TEST_CASE("concentric spheres deviate by the difference of their radii", "[occ][oracle]") {
    const CadReference small = sphere(10.0), large = sphere(10.25);
    for (const Deviation& d :
         {occ::measure_deviation(small, large, 500), occ::measure_deviation(large, small, 500)}) {
        CHECK(d.max == Approx(0.25).epsilon(1e-9));
        CHECK(d.rms == Approx(0.25).epsilon(1e-9));
        CHECK(d.p95 == Approx(0.25).epsilon(1e-9));
        CHECK(d.p99 == Approx(0.25).epsilon(1e-9));
        CHECK(d.face == 0);
        CHECK(d.samples > 500);
    }
}

TEST_CASE("a model does not deviate from itself", "[occ][oracle]") {
    for (const TopoDS_Shape& shape : {test::wing(), test::cut_cylinder()}) {
        const CadReference reference(test::model_of(shape));
        const Deviation d = occ::measure_deviation(reference, reference, 1000);
        CHECK(d.max < 2e-7);
        CHECK(d.rms <= d.max);
    }
}

TEST_CASE("the place and face of the largest deviation are reported", "[occ][oracle]") {
    // The taller box's top is 2 above the other's, and nothing else differs by as much.
    const CadReference low(test::model_of(BRepPrimAPI_MakeBox(10.0, 10.0, 10.0).Shape()));
    const CadReference tall(test::model_of(BRepPrimAPI_MakeBox(10.0, 10.0, 12.0).Shape()));
    const Deviation d = occ::measure_deviation(tall, low, 1000);
    CHECK(d.max == Approx(2.0));
    CHECK(d.at.z() == Approx(12.0));
    CHECK(d.rms < 2.0);
    CHECK(d.p95 <= d.p99);
    CHECK(d.p99 <= d.max);
}

TEST_CASE("deviations do not depend on the number of threads", "[occ]") {
    const CadReference wing(test::model_of(test::wing()));
    const CadReference cut(test::model_of(
        BRepAlgoAPI_Cut(test::wing(), test::rotated_box(200, 60, 100, gp_Pnt(10, -30, 220), 0.4))
            .Shape()));
    base::set_thread_count(1);
    const Deviation one = occ::measure_deviation(wing, cut, 2000);
    base::set_thread_count(0);
    const Deviation all = occ::measure_deviation(wing, cut, 2000);
    CHECK(one.max == all.max);
    CHECK(one.rms == all.rms);
    CHECK(one.p95 == all.p95);
    CHECK(one.at == all.at);
    CHECK(one.max > 1.0);
}

TEST_CASE("measuring a deviation can be stopped, and needs samples", "[occ]") {
    const CadReference reference = sphere(1.0);
    CHECK_THROWS_AS(occ::measure_deviation(reference, reference, 0), base::InvalidArgument);
    CHECK_THROWS_AS(occ::measure_deviation(reference, reference, 10,
                                           [](std::string_view, double) { return false; }),
                    base::Cancelled);
}
