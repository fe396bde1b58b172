#include "occ/random_patches.h"
#include "occ/shapes.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/mesh/obj.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/occ/cad_reference.h>
#include <patchwright/occ/inspect.h>
#include <patchwright/patch/extract.h>
#include <patchwright/subd/limit_mask.h>

#include <BRepPrimAPI_MakeCone.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Controller.hxx>
#include <catch2/catch.hpp>
#include <sched.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

using namespace patchwright;
using base::LengthUnit;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

/// An empty folder that is removed at the end.
class Folder {
  public:
    Folder()
        : path_(fs::temp_directory_path() / ("patchwright_test_" + std::to_string(::getpid()))) {
        fs::remove_all(path_);
        fs::create_directories(path_);
    }
    ~Folder() { fs::remove_all(path_); }
    fs::path operator/(const std::string& name) const { return path_ / name; }
    [[nodiscard]] std::size_t size() const {
        return std::size_t(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
    }

  private:
    fs::path path_;
};

std::string text_of(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    std::stringstream text;
    text << stream.rdbuf();
    return text.str();
}

void put(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

occ::CadModel smooth_cube() {
    mesh::TopologyInput tags;
    tags.face_group = {0, 0, 1, 1, 1, 1};
    tags.group_names = {"ends", "sides"};
    return occ::assemble(patch::extract(test::cube(40.0, tags)).patches);
}

/// Six loose faces of a box, each moved outward by `gap`, two of them turned.
occ::CadModel loose_box(double size, double gap) {
    TopoDS_Compound faces;
    const BRep_Builder builder;
    builder.MakeCompound(faces);
    int n = 0;
    for (TopExp_Explorer it(BRepPrimAPI_MakeBox(size, size, size).Shape(), TopAbs_FACE); it.More();
         it.Next(), ++n) {
        gp_Trsf move;
        move.SetTranslation(gp_Vec(n == 0 ? -gap : 0.0, n == 2 ? -gap : 0.0, n == 5 ? gap : 0.0));
        const TopoDS_Shape face = it.Current().Moved(TopLoc_Location(move));
        builder.Add(faces, n % 3 == 0 ? face.Reversed() : face);
    }
    return test::model_of(faces);
}

}  // namespace

TEST_CASE("every format and unit keeps size, names and topology", "[occ][oracle]") {
    const Folder folder;
    const occ::CadModel model = smooth_cube();
    const occ::Inspection before = occ::inspect(model);
    for (const LengthUnit unit : {LengthUnit::Millimetre, LengthUnit::Centimetre, LengthUnit::Metre,
                                  LengthUnit::Inch, LengthUnit::Foot}) {
        for (const char* name : {"a.step", "a.STP", "a.igs", "a.iges"}) {
            CAPTURE(name, base::short_name(unit));
            const fs::path path = folder / name;
            occ::write_cad(model, path, {.unit = unit});
            const occ::ReadResult read = occ::read_cad(path);
            CHECK(read.report.unit == unit);
            CHECK(read.report.faces_in_file == 6);
            CHECK(read.report.originating_system.find("patchwright") != std::string::npos);
            CHECK(read.report.notices.empty());
            const occ::Inspection after = occ::inspect(read.model);
            CHECK(after.volume_mm3 == Approx(before.volume_mm3).epsilon(1e-9));
            CHECK(after.area_mm2 == Approx(before.area_mm2).epsilon(1e-9));
            CHECK(after.solids == 1);
            CHECK(after.faces == 6);
            CHECK(after.edges == 12);
            CHECK(after.closed);
            CHECK(after.valid);
            CHECK(after.all_bicubic);
        }
    }
    occ::write_cad(model, folder / "a.brep");
    CHECK(occ::inspect(occ::read_cad(folder / "a.brep").model).volume_mm3 ==
          Approx(before.volume_mm3).epsilon(1e-12));
    CHECK(folder.size() == 5);
}

TEST_CASE("schemas are what they say, faces are named, bytes are reproducible", "[occ]") {
    const Folder folder;
    const occ::CadModel model = smooth_cube();
    const std::vector<std::pair<occ::StepSchema, std::string>> schemas{
        {occ::StepSchema::Ap203, "AP203"},
        {occ::StepSchema::Ap214, "AP214"},
        {occ::StepSchema::Ap242, "AP242"}};
    for (const auto& [schema, name] : schemas) {
        occ::write_cad(model, folder / "a.step", {.schema = schema});
        const std::string text = text_of(folder / "a.step");
        CHECK(occ::read_cad(folder / "a.step").report.schema == name);
        CHECK_THAT(text, Contains("ADVANCED_FACE('ends/chart 0'") &&
                             Contains("ADVANCED_FACE('sides/chart 5'"));
        occ::write_cad(model, folder / "a.step", {.schema = schema});
        CHECK(text_of(folder / "a.step") == text);
    }
    for (const char* name : {"a.igs", "a.brep"}) {
        occ::write_cad(model, folder / name);
        const std::string text = text_of(folder / name);
        occ::write_cad(model, folder / name);
        CHECK(text_of(folder / name) == text);
    }
}

TEST_CASE("AP203 is written where the host's name has no address", "[occ]") {
    // As in containers without a network. Other processes keep the name.
    if (unshare(CLONE_NEWUTS) != 0 || sethostname("host.invalid", 12) != 0)
        WARN("the host's name cannot be changed here: tried with the one it has");
    const Folder folder;
    occ::write_cad(smooth_cube(), folder / "a.step", {.schema = occ::StepSchema::Ap203});
    const std::string text = text_of(folder / "a.step");
    CHECK(text.find("PERSON('unknown'") != std::string::npos);
    CHECK(text.find("ORGANIZATION('unknown','unspecified'") != std::string::npos);
}

TEST_CASE("the kernel's global parameters are as before", "[occ]") {
    STEPControl_Controller::Init();
    IGESControl_Controller::Init();
    const Folder folder;
    const char* watched[] = {"write.step.schema",  "write.step.unit", "write.step.product.name",
                             "xstep.cascade.unit", "write.iges.unit", "write.iges.brep.mode"};
    const auto values = [&] {
        std::vector<std::string> all;
        for (const char* name : watched) all.emplace_back(Interface_Static::CVal(name));
        return all;
    };
    const auto before = values();
    for (const char* name : {"a.step", "a.igs"}) {
        occ::write_cad(smooth_cube(), folder / name,
                       {.unit = LengthUnit::Foot, .schema = occ::StepSchema::Ap203});
        occ::read_cad(folder / name);
    }
    CHECK(values() == before);
}

TEST_CASE("a unit that lies is overridden", "[occ][oracle]") {
    const Folder folder;
    occ::write_cad(test::model_of(BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()), folder / "box.step");
    const occ::ReadResult read = occ::read_cad(folder / "box.step", {.unit = LengthUnit::Metre});
    CHECK(occ::inspect(read.model).volume_mm3 == Approx(6e9));
    CHECK(read.report.unit == LengthUnit::Metre);
    CHECK(read.report.notices.size() == 1);
}

TEST_CASE("a file without a known unit needs one to be given", "[occ][errors][oracle]") {
    const Folder folder;
    const occ::CadModel box = test::model_of(BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape());
    occ::write_cad(box, folder / "box.step");
    occ::write_cad(box, folder / "box.igs");
    // The kernel takes these for metres, millimetres, millimetres, nothing and inches.
    const std::vector<std::tuple<std::string, std::string, std::string>> edits{
        {"box.step", "SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT(.MILLY.,.METRE.)"},
        {"box.step", "SI_UNIT(.MILLI.,.METRE.)", ""},
        {"box.step", "GLOBAL_UNIT_ASSIGNED_CONTEXT", "GLOBAL_FANCY_ASSIGNED_CONTEXT"},
        {"box.igs", ",2,2HMM,", ",77,,   "},
        {"box.igs", ",2,2HMM,", ",,,     "},
        {"box.igs", ",2,2HMM,", ",3,2HXX,"}};
    for (const auto& [name, known, unknown] : edits) {
        CAPTURE(unknown);
        std::string text = text_of(folder / name);
        const auto at = text.find(known);
        REQUIRE(at != std::string::npos);
        put(folder / ("edited_" + name), text.replace(at, known.size(), unknown));
        const fs::path edited = folder / ("edited_" + name);
        CHECK_THROWS_AS(occ::read_cad(edited), base::InputError);
        CHECK_THROWS_WITH(occ::read_cad(edited), Contains("unit") && Contains("--input-unit"));
        const occ::ReadResult read = occ::read_cad(edited, {.unit = LengthUnit::Inch});
        CHECK(occ::inspect(read.model).volume_mm3 == Approx(6.0 * std::pow(25.4, 3)));
        CHECK(read.report.unit == LengthUnit::Inch);
    }
}

TEST_CASE("units without a short name keep their size", "[occ][oracle]") {
    const Folder folder;
    occ::write_cad(test::model_of(BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()), folder / "box.step");
    std::string text = text_of(folder / "box.step");
    text.replace(text.find(".MILLI."), 7, ".MICRO.");
    put(folder / "box.step", text);
    const occ::ReadResult read = occ::read_cad(folder / "box.step");
    CHECK(occ::inspect(read.model).volume_mm3 == Approx(6e-9));
    REQUIRE(read.report.notices.size() == 1);
    CHECK_THAT(read.report.notices.front(), Contains("0.001 mm"));
    const occ::ReadResult inches = occ::read_cad(folder / "box.step", {.unit = LengthUnit::Inch});
    CHECK(occ::inspect(inches.model).volume_mm3 == Approx(6.0 * std::pow(25.4, 3)));
}

TEST_CASE("loose, gappy, turned faces are sewn to an outward solid", "[occ][oracle]") {
    const Folder folder;
    const double size = 100.0;
    const double gap = GENERATE(0.0, 1e-3, 2e-2);
    occ::write_cad(loose_box(size, gap), folder / "loose.igs");
    const occ::ReadResult read = occ::read_cad(folder / "loose.igs");
    const occ::Inspection i = occ::inspect(read.model);
    CHECK(i.solids == 1);
    CHECK(i.closed);
    CHECK(i.volume_mm3 == Approx(size * size * size).epsilon(1e-3));
    CHECK(read.report.free_edges_before == 24);
    CHECK(read.report.free_edges_after == 0);
    REQUIRE(read.report.sewn);
    CHECK(read.report.sewn->largest_mm <= 1.5 * gap + 1e-6);
    CHECK(read.report.sewn->largest_mm >= 0.5 * gap);

    const occ::ReadResult as_is = occ::read_cad(folder / "loose.igs", {.heal = false});
    CHECK(occ::inspect(as_is.model).free_edges == 24);
    CHECK(occ::inspect(as_is.model).solids == 0);
}

TEST_CASE("gaps that are too large stay open and are reported", "[occ]") {
    const Folder folder;
    occ::write_cad(loose_box(100.0, 5.0), folder / "loose.igs");
    const occ::ReadResult read = occ::read_cad(folder / "loose.igs");
    CHECK(read.report.free_edges_after > 0);
    CHECK(occ::inspect(read.model).solids == 0);
}

TEST_CASE("unusable files are refused in one line that names them", "[occ][errors]") {
    const Folder folder;
    occ::write_cad(smooth_cube(), folder / "good.step");
    occ::write_cad(smooth_cube(), folder / "good.igs");
    const std::string step = text_of(folder / "good.step");
    const std::string iges = text_of(folder / "good.igs");
    const auto cut = [](const std::string& text) { return text.substr(0, text.size() / 2); };
    const std::vector<std::tuple<std::string, std::string, std::string>> cases{
        {"text.step", "This is text.\n", "not a STEP file"},
        {"empty.step", "", "empty"},
        {"cut.step", cut(step), "cut off"},
        {"hollow.step",
         "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','',''"
         ");\n"
         "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n",
         ""},
        {"text.igs", "This is text.\n", "not an IGES file"},
        {"cut.igs", cut(iges), "cut off"},
        {"swapped.igs", step, "not an IGES file"},
        {"text.brep", "This is text.\n", "not a BREP file"},
        {"cut.brep", "CASCADE Topology V1, (c) Matra-Datavision\nLocations 7\n", ""},
        {"x.dwg", "x", "unknown kind"},
    };
    for (const auto& [name, text, part] : cases) {
        CAPTURE(name);
        put(folder / name, text);
        CHECK_THROWS_WITH(occ::read_cad(folder / name),
                          Contains(name) && Contains(part) && !Contains("\n"));
        CHECK_THROWS_AS(occ::read_cad(folder / name), base::InputError);
    }
    CHECK_THROWS_WITH(occ::read_cad(folder / "none.step"),
                      Contains("none.step") && Contains("exist"));
}

TEST_CASE("what cannot be written leaves the old file and nothing else", "[occ][errors]") {
    const Folder folder;
    put(folder / "a.step", "old");
    CHECK_THROWS_AS(occ::write_cad(smooth_cube(), folder / "none/a.step"), base::OutputError);
    CHECK_THROWS_AS(occ::write_cad(smooth_cube(), folder / "a.xyz"), base::InputError);
    CHECK(text_of(folder / "a.step") == "old");
    CHECK(folder.size() == 1);
}

TEST_CASE("limit points lie on the surfaces of the file read back", "[occ][oracle]") {
    const Folder folder;
    std::vector<mesh::Cage> cages{test::grid(3, 3)};
    for (const char* name : {"cube", "cube_rim", "torus", "genus2", "dish"}) {
        cages.push_back(mesh::read_obj(fs::path(PATCHWRIGHT_SAMPLES_DIR) / "cages" /
                                       (std::string(name) + ".obj"))
                            .cage);
    }
    for (unsigned seed = 0; seed < 4; ++seed) cages.push_back(test::random_cage(seed));
    for (const mesh::Cage& cage : cages) {
        constexpr int depth = 4;
        const auto extraction =
            patch::extract(cage, {.covering = patch::Covering::Faces, .cap_depth = depth});
        occ::write_cad(occ::assemble(extraction.patches), folder / "a.step");
        const occ::CadReference written(occ::read_cad(folder / "a.step", {.heal = false}).model);
        const subd::LimitEvaluator evaluator(extraction.cage.topology);
        double worst = 0.0;
        for (const mesh::FaceId f : extraction.cage.topology->faces()) {
            // Outside the caps, which are squares of at most 1/8 at the corners.
            for (const auto& [u, v] :
                 {std::pair{0.5, 0.5}, {0.13, 0.0}, {1.0, 0.3}, {0.2, 0.87}, {0.8, 0.8}}) {
                const geom::Vec3 p = evaluator.position(extraction.cage.points, {f, u, v});
                worst = std::max(worst, written.foot_point(p).distance);
            }
        }
        CHECK(worst < 1e-9 * written.bounds().diagonal());
    }
}

TEST_CASE("random cages come back from STEP without gaps and kinks", "[occ][oracle]") {
    // bench_patches does the same for 200 and more.
    const Folder folder;
    for (unsigned seed = 0; seed < 30; ++seed) {
        CAPTURE(seed);
        const test::RandomPatches result = test::write_random_patches(seed, folder / "a.step");
        CHECK(result.inspection.valid);
        CHECK(result.inspection.all_bicubic);
        CHECK(result.inspection.closed == result.closed);
        CHECK(result.inspection.nonmanifold_edges == 0);
        CHECK(result.relative_gap <= 1e-9);
        CHECK(result.kink_deg <= 1e-5);
    }
}

TEST_CASE("reading, sewing and triangulating stop when asked", "[occ]") {
    const Folder folder;
    const fs::path path = folder / "loose.igs";
    occ::write_cad(loose_box(100.0, 1e-3), path);
    const occ::CadModel model = occ::read_cad(path).model;
    const auto polls_of = [](const auto& work) {
        // Stopped at the first poll, at the second, ..., until it comes to its end.
        for (int allowed = 0;; ++allowed) {
            int polls = 0;
            const base::Progress progress = [&](std::string_view, double) {
                return ++polls <= allowed;
            };
            try {
                work(progress);
                return polls;
            } catch (const base::Cancelled&) {
                CHECK(polls == allowed + 1);
            }
        }
    };
    CHECK(polls_of([&](const base::Progress& p) { occ::read_cad(path, {.progress = p}); }) >= 5);
    CHECK(polls_of([&](const base::Progress& p) { occ::CadReference(model, {.progress = p}); }) >=
          6);
}
