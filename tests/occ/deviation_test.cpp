#include "occ/shapes.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/measure/deviation.h>
#include <patchwright/measure/field.h>
#include <patchwright/occ/inspect.h>

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <GProp_GProps.hxx>
#include <catch2/catch.hpp>
#include <gp_Pln.hxx>

#include <Eigen/Geometry>

using namespace patchwright;
using geom::Vec3;
using measure::Deviation;
using occ::CadReference;

namespace {

CadReference sphere(double radius) {
    return CadReference(test::model_of(BRepPrimAPI_MakeSphere(radius).Shape()));
}

}  // namespace

TEST_CASE("concentric spheres deviate by the difference of their radii", "[occ][oracle]") {
    const CadReference small = sphere(10.0), large = sphere(10.25);
    for (const Deviation& d : {measure::measure_deviation(small, large, {.samples = 500}),
                               measure::measure_deviation(large, small, {.samples = 500})}) {
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
        const Deviation d = measure::measure_deviation(reference, reference, {.samples = 1000});
        CHECK(d.max < 2e-7);
        CHECK(d.rms <= d.max);
    }
}

TEST_CASE("the place and face of the largest deviation are reported", "[occ][oracle]") {
    // The taller box's top is 2 above the other's, and nothing else differs by as much.
    const CadReference low(test::model_of(BRepPrimAPI_MakeBox(10.0, 10.0, 10.0).Shape()));
    const CadReference tall(test::model_of(BRepPrimAPI_MakeBox(10.0, 10.0, 12.0).Shape()));
    const Deviation d = measure::measure_deviation(tall, low, {.samples = 1000});
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
    const Deviation one = measure::measure_deviation(wing, cut, {.samples = 2000});
    base::set_thread_count(0);
    const Deviation all = measure::measure_deviation(wing, cut, {.samples = 2000});
    CHECK(one.max == all.max);
    CHECK(one.rms == all.rms);
    CHECK(one.p95 == all.p95);
    CHECK(one.at == all.at);
    CHECK(one.max > 1.0);
}

TEST_CASE("measuring a deviation can be stopped, and needs samples", "[occ]") {
    const CadReference reference = sphere(1.0);
    CHECK_THROWS_AS(measure::measure_deviation(reference, reference, {.samples = 0}),
                    base::InvalidArgument);
    CHECK_THROWS_AS(
        measure::measure_deviation(
            reference, reference,
            {.samples = 10, .progress = [](std::string_view, double) { return false; }}),
        base::Cancelled);
}

TEST_CASE("the bound holds all points and comes near the largest sample", "[occ][oracle]") {
    const CadReference small = sphere(10.0), large = sphere(10.25);
    const Deviation out = measure::measure_deviation(small, large, {.samples = 300});
    CHECK(out.bound >= 0.25);
    CHECK(out.bound <= 1.11 * 0.25);

    // A box with a small bump: few samples miss its top, the bound does not.
    const TopoDS_Shape bump = BRepPrimAPI_MakeSphere(gp_Pnt(31.3, 22.7, 0.0), 0.8).Shape();
    const CadReference plain(test::model_of(BRepPrimAPI_MakeBox(100.0, 100.0, 10.0).Shape()));
    const CadReference bumpy(test::model_of(
        BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(100.0, 100.0, 10.0).Shape(), bump).Shape()));
    const Deviation d = measure::measure_deviation(bumpy, plain, {.samples = 50});
    CHECK(d.bound >= 0.8);
    CHECK(d.bound <= 1.2 * 0.8);
    CHECK_FALSE(measure::measure_deviation(plain, bumpy, {.samples = 10, .with_bound = false})
                    .bound.has_value());
    for (std::size_t i = 1; i < d.worst.size(); ++i) {
        CHECK(d.worst[i].distance <= d.worst[i - 1].distance);
        for (std::size_t k = 0; k < i; ++k)
            CHECK((d.worst[i].point - d.worst[k].point).norm() > 0.04 * 141.0);
    }
}

TEST_CASE("samples stand for the area they come from", "[occ][oracle]") {
    // Half of the samples crowd where the surface bends; the weights make up for it.
    const TopoDS_Shape shape = test::cut_cylinder();
    const CadReference reference(test::model_of(shape));
    const occ::Inspection found = occ::inspect(test::model_of(shape));
    double area = 0.0, height = 0.0;
    for (const auto& sample : reference.sample(4000)) {
        area += sample.weight;
        height += sample.weight * sample.point.z();
    }
    CHECK(area == Approx(found.area_mm2).epsilon(0.01));
    GProp_GProps properties;
    BRepGProp::SurfaceProperties(shape, properties);
    CHECK(height / area == Approx(properties.CentreOfMass().Z()).epsilon(0.01));
}

TEST_CASE("sharp edges are compared with sharp edges", "[occ][oracle]") {
    const auto box = [](double height) {
        return CadReference(test::model_of(BRepPrimAPI_MakeBox(10.0, 10.0, height).Shape()));
    };
    const auto d =
        measure::measure_feature_deviation(box(12.0), box(10.0), geom::FeatureKind::Sharp);
    REQUIRE(d.has_value());
    CHECK(d->max == Approx(2.0));
    // 4 of 12 edges are 2 off all along, 4 by up to 2 over a sixth of their length.
    CHECK(d->p50 == Approx(0.0).margin(1e-9));
    CHECK(d->rms == Approx(std::sqrt((40.0 * 4.0 + 4 * 8.0 / 3.0) / 128.0)).epsilon(0.01));
    CHECK_FALSE(measure::measure_feature_deviation(box(1.0), sphere(1.0), geom::FeatureKind::Sharp)
                    .has_value());
}

TEST_CASE("sharp curves are looked at one by one", "[occ][oracle]") {
    const auto box = [](double height) {
        return CadReference(test::model_of(BRepPrimAPI_MakeBox(10.0, 10.0, height).Shape()));
    };
    // Edges of the lid are 2 off, upright ones at their upper ends, those of the floor not at all.
    const CadReference tall = box(12.0), low = box(10.0);
    const auto all = measure::measure_sharp_curves(tall, low, 1.0);
    REQUIRE(all.size() == 12);
    int off = 0;
    for (const auto& c : all) {
        CHECK((c.distance == Approx(2.0) || c.distance == Approx(0.0).margin(1e-9)));
        if (c.distance < 1.0) continue;
        ++off;
        CHECK(c.at.z() == Approx(12.0));
    }
    CHECK(off == 8);
    // Only the four upright ones are longer than 11.
    const auto longest = measure::measure_sharp_curves(tall, low, 11.0);
    REQUIRE(longest.size() == 4);
    for (const auto& c : longest) CHECK(c.length == Approx(12.0));
    for (const auto& c : measure::measure_sharp_curves(low, sphere(5.0), 1.0))
        CHECK(std::isinf(c.distance));
    // An open surface is not smooth where it ends: the lid alone, all edges of which are free.
    const CadReference lid(test::model_of(
        BRepBuilderAPI_MakeFace(gp_Pln(gp_Pnt(0, 0, 10), gp_Dir(0, 0, 1)), 0, 10, 0, 10).Face()));
    int on_border = 0;
    for (const auto& c : measure::measure_sharp_curves(low, lid, 1.0)) {
        CHECK((c.distance == Approx(10.0) || c.distance == Approx(0.0).margin(1e-9)));
        on_border += c.distance < 1.0 ? 1 : 0;
    }
    CHECK(on_border == 4);
}

TEST_CASE("the field between two spheres is what the radii say, on triangles that cover one",
          "[measure][oracle]") {
    const double r = 50.0, outer = 51.0;
    const CadReference inside = sphere(r), outside = sphere(outer);
    const measure::FieldOptions options{.longest_side_rel = 0.05};
    const measure::Field field = measure::measure_field(inside, &outside, options);
    const double longest = options.longest_side_rel * inside.bounds().diagonal();
    double area = 0.0;
    for (const auto& t : field.triangles) {
        geom::Vec3 p[3], normals = geom::Vec3::Zero();
        for (int k = 0; k < 3; ++k) {
            p[k] = field.points.row(t[std::size_t(k)]);
            normals += field.normals.row(t[std::size_t(k)]);
        }
        for (int k = 0; k < 3; ++k) CHECK((p[k] - p[(k + 1) % 3]).norm() <= longest);
        const geom::Vec3 twice = (p[1] - p[0]).cross(p[2] - p[0]);
        CHECK(twice.dot(normals) >= 0.0);
        area += 0.5 * twice.norm();
    }
    CHECK(area == Approx(4.0 * M_PI * r * r).epsilon(5e-3));
    REQUIRE(field.distance_mm.size() == std::size_t(field.points.rows()));
    for (std::size_t i = 0; i < field.distance_mm.size(); ++i) {
        CHECK(field.distance_mm[i] == Approx(outer - r).epsilon(1e-6));
        CHECK(field.normal_angle_rad[i] == Approx(0.0).margin(1e-5));
        // The poles are degenerate.
        if (std::abs(field.points(Eigen::Index(i), 2)) > (1.0 - 1e-9) * r) continue;
        CHECK(field.curvature[i] == Approx(-1.0 / r).epsilon(1e-6));
        CHECK(field.other_curvature[i] == Approx(-1.0 / outer).epsilon(1e-6));
    }
    CHECK(measure::measure_field(inside, nullptr, options).distance_mm.empty());
}
