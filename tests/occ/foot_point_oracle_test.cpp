// A part of what check_footpoint does, short enough for every day.
#include "occ/foot_point_oracle.h"

#include <patchwright/occ/inspect.h>

#include <BRepBuilderAPI_MakePolygon.hxx>
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

using namespace patchwright;

TEST_CASE("foot points of files are no farther than the kernel's", "[occ][legacy][oracle]") {
    const std::filesystem::path samples = PATCHWRIGHT_SAMPLES_DIR;
    const std::filesystem::path legacy = PATCHWRIGHT_LEGACY_CAD_DIR;
    const std::vector<std::filesystem::path> files{
        samples / "wing" / "wing.igs",     legacy / "tigl_d150_wing.igs",
        legacy / "nosecone_sw.step",       legacy / "naca_wing_dealii.iges",
        legacy / "seat_cpacs.stp",         legacy / "dtmb5415_bow.iges",
        legacy / "c172_wing_pyspline.igs", legacy / "endplate_wing_vsp.stp"};
    for (const auto& file : files) {
        CAPTURE(file.string());
        if (!std::filesystem::exists(file)) {
            WARN("skipped: " << file.string() << " is not there");
            continue;
        }
        const occ::CadModel model = occ::read_cad(file).model;
        const occ::CadReference reference(model);
        const double size = reference.bounds().diagonal();
        const double tolerance = 1e-7 * size + occ::inspect(model).max_tolerance_mm;
        const test::OracleResult found = test::compare_with_kernel(
            reference, test::faces_only(model.impl().shape), 240, 2, tolerance);
        CAPTURE(found.worst.kind, found.worst.point.transpose());
        CHECK(found.points > 200);
        CHECK(found.kinds.size() == 6);
        CHECK(found.farther <= tolerance);
    }
}

TEST_CASE("foot points between many small faces are no farther than the kernel's",
          "[occ][oracle]") {
    // Edges are left out of a search where the foot is alone; here they are as near as the faces.
    for (const int side : {3, 7, 20}) {
        CAPTURE(side);
        const occ::CadModel model = test::wavy_sheet(side);
        const occ::CadReference reference(model);
        const double tolerance = 1e-9 * reference.bounds().diagonal();
        const test::OracleResult found = test::compare_with_kernel(
            reference, test::faces_only(model.impl().shape), 600, 5, tolerance);
        CAPTURE(found.worst.kind, found.worst.point.transpose());
        CHECK(found.points > 500);
        CHECK(found.farther <= tolerance);
    }
}

TEST_CASE("an edge is found though a face behind it has a foot of its own", "[occ]") {
    // A triangle over a large plate: off its long side its own foot is trimmed away.
    const auto face = [](const std::vector<gp_Pnt>& corners) {
        BRepBuilderAPI_MakePolygon polygon;
        for (const gp_Pnt& p : corners) polygon.Add(p);
        polygon.Close();
        return BRepBuilderAPI_MakeFace(polygon.Wire()).Face();
    };
    TopoDS_Compound both;
    const BRep_Builder builder;
    builder.MakeCompound(both);
    builder.Add(both, face({{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}));
    builder.Add(both, face({{-50, -50, -3}, {50, -50, -3}, {50, 50, -3}, {-50, 50, -3}}));
    const occ::CadReference reference(test::model_of(both));
    for (const double x : {5.1, 6.0, 7.0, 8.0}) {
        for (const double off : {-2.0, 0.1, 2.0}) {
            const geom::Vec3 query(x + off, x - off, 0.0);
            CAPTURE(query.transpose());
            const double to_side = (2.0 * x - 10.0) / std::sqrt(2.0);
            CHECK(reference.foot_point(query).distance ==
                  Approx(std::min(to_side, 3.0)).epsilon(1e-12));
        }
    }
}
