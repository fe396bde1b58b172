#include "occ/kernel_points.h"
#include "occ/shapes.h"

#include <patchwright/base/error.h>

#include <BRep_Tool.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <catch2/catch.hpp>

#include <fstream>

using namespace patchwright;
using occ::CadModel;
using occ::Colour;

namespace {

std::filesystem::path scratch(const std::string& name) {
    const auto folder = std::filesystem::temp_directory_path() / "patchwright_face_attributes";
    std::filesystem::create_directories(folder);
    return folder / name;
}

/// A box, or its loose faces, with names and colours on some faces.
CadModel painted(bool loose) {
    auto impl = std::make_shared<CadModel::Impl>();
    impl->shape = BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape();
    if (loose) impl->shape = test::faces_only(impl->shape);
    impl->face_names = {"root", "", "tip", "upper skin, third bay", "", "lower"};
    impl->face_colours = {Colour{1, 0, 0}, std::nullopt,        Colour{0.25, 0.5, 0.75},
                          Colour{1, 0, 0}, Colour{0.1, 0.2, 0}, std::nullopt};
    return CadModel(impl);
}

/// What of the model's faces came through, by the faces' centres: numbers may change.
void check_same(const CadModel& before, const CadModel& after, double tolerance) {
    const auto centre = [](const TopoDS_Face& face) {
        geom::Box3 box;
        for (TopExp_Explorer it(face, TopAbs_VERTEX); it.More(); it.Next())
            box.add(occ::vec(BRep_Tool::Pnt(TopoDS::Vertex(it.Current()))));
        return box.centre();
    };
    const auto old_faces = occ::faces_of(before), faces = occ::faces_of(after);
    const auto old_names = occ::face_names(before), names = occ::face_names(after);
    const auto old_colours = occ::face_colours(before), colours = occ::face_colours(after);
    REQUIRE(faces.size() == old_faces.size());
    REQUIRE(names.size() == faces.size());
    REQUIRE(colours.size() == faces.size());
    for (std::size_t i = 0; i < faces.size(); ++i) {
        int found = 0;
        for (std::size_t k = 0; k < faces.size(); ++k) {
            if ((centre(faces[k]) - centre(old_faces[i])).norm() > 1e-6) continue;
            ++found;
            CHECK(names[k] == old_names[i]);
            REQUIRE(colours[k].has_value() == old_colours[i].has_value());
            if (!colours[k]) continue;
            CHECK(colours[k]->red == Approx(old_colours[i]->red).margin(tolerance));
            CHECK(colours[k]->green == Approx(old_colours[i]->green).margin(tolerance));
            CHECK(colours[k]->blue == Approx(old_colours[i]->blue).margin(tolerance));
        }
        CHECK(found == 1);
    }
}

}  // namespace

TEST_CASE("names and colours of faces go through files and sewing", "[occ][attributes]") {
    for (const bool loose : {false, true}) {
        const CadModel model = painted(loose);
        for (const char* name : {"box.step", "box.igs"}) {
            CAPTURE(loose, name);
            occ::write_cad(model, scratch(name));
            const occ::ReadResult read = occ::read_cad(scratch(name));
            CHECK(read.report.free_edges_after == 0);
            // The kernel keeps colours in single precision.
            check_same(model, read.model, 1e-5);
            CHECK(occ::face_names(
                      occ::read_cad(scratch(name), {.unit = base::LengthUnit::Inch}).model) ==
                  occ::face_names(read.model));
        }
    }
    for (const auto schema :
         {occ::StepSchema::Ap203, occ::StepSchema::Ap214, occ::StepSchema::Ap242}) {
        occ::write_cad(painted(false), scratch("schema.step"), {.schema = schema});
        check_same(painted(false), occ::read_cad(scratch("schema.step")).model, 1e-5);
    }
}

TEST_CASE("painted files are the same every time", "[occ][attributes]") {
    const auto bytes = [](const std::filesystem::path& path) {
        std::ifstream stream(path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(stream), {});
    };
    for (const char* name : {"twice.step", "twice.igs"}) {
        occ::write_cad(painted(false), scratch(name));
        const std::string first = bytes(scratch(name));
        occ::write_cad(painted(false), scratch(name));
        CHECK(first == bytes(scratch(name)));
        CHECK(first.size() > 1000);
    }
}

TEST_CASE("a model can be given other colours", "[occ][attributes]") {
    const CadModel model = painted(false);
    const CadModel grey =
        occ::with_face_colours(model, std::vector<std::optional<Colour>>(6, Colour{0.5, 0.5, 0.5}));
    CHECK(occ::face_colours(grey)[1] == Colour{0.5, 0.5, 0.5});
    CHECK(occ::face_names(grey) == occ::face_names(model));
    CHECK_THROWS_AS(occ::with_face_colours(model, {}), base::InvalidArgument);
}
