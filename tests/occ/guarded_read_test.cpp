// Reading in a process of its own: the same model, and what becomes of files that end it.
#define CATCH_CONFIG_EXTERNAL_INTERFACES  // for the listener
#include "occ/shapes.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/occ/guarded_read.h>
#include <patchwright/occ/inspect.h>
#include <patchwright/patch/extract.h>

#include <catch2/catch.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <future>
#include <regex>
#include <sstream>
#include <thread>

using namespace patchwright;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

occ::ReaderProcess& reader() {
    static occ::ReaderProcess process;
    return process;
}

/// Before any test has made threads.
struct ReaderStart : Catch::TestEventListenerBase {
    using TestEventListenerBase::TestEventListenerBase;
    void testRunStarting(const Catch::TestRunInfo&) override { reader(); }
};
CATCH_REGISTER_LISTENER(ReaderStart)

class Scratch {
  public:
    Scratch()
        : path_(fs::temp_directory_path() / ("patchwright_guard_" + std::to_string(::getpid()))) {
        fs::create_directories(path_);
    }
    ~Scratch() { fs::remove_all(path_); }
    fs::path operator/(const std::string& name) const { return path_ / name; }

  private:
    fs::path path_;
};

/// A box as a file whose first match of the pattern is replaced.
fs::path edited_box(const Scratch& folder, const std::string& pattern, const std::string& with,
                    const std::string& name = "edited.step") {
    const fs::path path = folder / name;
    occ::write_cad(test::model_of(BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()), path);
    std::stringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    const std::regex expression(pattern);
    REQUIRE(std::regex_search(text.str(), expression));
    std::ofstream(path, std::ios::binary) << std::regex_replace(
        text.str(), expression, with, std::regex_constants::format_first_only);
    return path;
}

std::string children_of(const std::string& process) {
    std::string children;
    std::getline(std::ifstream("/proc/" + process + "/task/" + process + "/children"), children);
    return children;
}

/// Workers of readers that have not ended.
bool has_workers() {
    std::istringstream readers(children_of(std::to_string(::getpid())));
    std::string process;
    while (readers >> process)
        if (!children_of(process).empty()) return true;
    return false;
}

}  // namespace

TEST_CASE("a model read by another process is the same", "[occ][guard][oracle]") {
    const Scratch folder;
    mesh::TopologyInput tags;
    tags.face_group = {0, 0, 1, 1, 1, 1};
    tags.group_names = {"ends", "sides"};
    const occ::CadModel cube = occ::assemble(patch::extract(test::cube(40.0, tags)).patches);
    std::vector<std::optional<occ::Colour>> colours(6);
    colours[2] = occ::Colour{1.0, 0.0, 0.5};
    std::vector<fs::path> files{fs::path(PATCHWRIGHT_SAMPLES_DIR) / "wing" / "wing.step",
                                fs::path(PATCHWRIGHT_SAMPLES_DIR) / "wing" / "wing.igs"};
    for (const char* name : {"a.step", "a.igs", "a.brep"}) {
        files.push_back(folder / name);
        occ::write_cad(occ::with_face_colours(cube, colours), files.back());
    }
    for (const fs::path& file : files) {
        CAPTURE(file.string());
        const occ::ReadResult here = occ::read_cad(file);
        const occ::ReadResult there = occ::read_cad_guarded(file, reader());
        CHECK(occ::face_names(there.model) == occ::face_names(here.model));
        CHECK(occ::face_colours(there.model) == occ::face_colours(here.model));
        CHECK(there.report.notices == here.report.notices);
        CHECK(there.report.schema == here.report.schema);
        CHECK(there.report.unit == here.report.unit);
        CHECK(there.report.faces_in_file == here.report.faces_in_file);
        CHECK(there.report.sewn.has_value() == here.report.sewn.has_value());
        const occ::Inspection a = occ::inspect(here.model), b = occ::inspect(there.model);
        CHECK(b.faces_by_kind == a.faces_by_kind);
        CHECK(b.edges == a.edges);
        CHECK(b.vertices == a.vertices);
        CHECK(b.solids == a.solids);
        CHECK(b.closed == a.closed);
        CHECK(b.valid == a.valid);
        CHECK(b.bounds.min == a.bounds.min);
        CHECK(b.bounds.max == a.bounds.max);
        CHECK(b.volume_mm3 == Approx(a.volume_mm3).epsilon(1e-12));
        CHECK(b.max_tolerance_mm == a.max_tolerance_mm);
    }
    CHECK_FALSE(has_workers());
}

TEST_CASE("options and errors cross over to the other process", "[occ][guard]") {
    const Scratch folder;
    const fs::path box = edited_box(folder, "ADVANCED_FACE", "FANCY_FACE");
    CHECK_THROWS_AS(occ::read_cad_guarded(box, reader()), base::InputError);
    CHECK_THROWS_WITH(occ::read_cad_guarded(box, reader()), Contains("FANCY_FACE: unknown entity"));
    const occ::ReadResult rest = occ::read_cad_guarded(
        box, reader(), {.unit = base::LengthUnit::Inch, .allow_loss = true, .heal = false});
    CHECK(rest.report.unit == base::LengthUnit::Inch);
    REQUIRE(rest.report.lost.size() == 1);
    CHECK(rest.report.lost[0].type == "FANCY_FACE");
    CHECK(occ::inspect(rest.model).bounds.max.z() == Approx(3.0 * 25.4));
    CHECK_THROWS_WITH(occ::read_cad_guarded(folder / "none.step", reader()), Contains("exist"));
}

TEST_CASE("a crash of the kernel is an error that names the entity", "[occ][guard][errors]") {
    // Kernel bug: vertices without a point are not looked for.
    const Scratch folder;
    const fs::path file =
        edited_box(folder, "VERTEX_POINT\\('',#[0-9]+\\)", "VERTEX_POINT('',#9999)");
    CHECK_THROWS_AS(occ::read_cad_guarded(file, reader()), base::InputError);
    CHECK_THROWS_WITH(occ::read_cad_guarded(file, reader()),
                      Contains("edited.step: the CAD kernel crashes on #") &&
                          Contains("ADVANCED_FACE") && !Contains("\n"));
}

TEST_CASE("what the kernel cannot read back of its own is an error of the file",
          "[occ][guard][errors]") {
    // A direction in the plane so long that its unit vector becomes zero.
    const Scratch folder;
    const fs::path file =
        edited_box(folder, "(Curve2ds [0-9]+\\s+1 [-0-9.]+ [-0-9.]+) [-0-9.]+ [-0-9.]+",
                   "$1 1e308 0", "edited.brep");
    CHECK_THROWS_AS(occ::read_cad_guarded(file, reader()), base::InputError);
    CHECK_THROWS_WITH(
        occ::read_cad_guarded(file, reader()),
        Contains("edited.brep: CAD kernel: ") && Contains("zero norm") && !Contains("\n"));
}

TEST_CASE("endless recursion of the kernel is an error", "[occ][guard][errors]") {
    // Kernel bug: an entity that refers to itself is followed for ever.
    const Scratch folder;
    const fs::path file =
        edited_box(folder, "(#[0-9]+)(=ORIENTED_EDGE\\('',\\*,\\*,)#[0-9]+", "$1$2$1");
    CHECK_THROWS_AS(occ::read_cad_guarded(file, reader()), base::InputError);
    CHECK_THROWS_WITH(occ::read_cad_guarded(file, reader()), Contains("endless recursion"));
}

TEST_CASE("limits of a reader process hold", "[occ][guard][errors]") {
    const fs::path file = fs::path(PATCHWRIGHT_SAMPLES_DIR) / "wing" / "wing.step";
    CHECK_THROWS_AS(occ::read_cad_guarded(file, reader(), {}, {.memory_mb = 1.0}),
                    base::InputError);
    CHECK_THROWS_WITH(occ::read_cad_guarded(file, reader(), {}, {.memory_mb = 1.0}),
                      Contains("more than 1 MB of memory"));
}

TEST_CASE("nothing is being read any more when reading is cancelled", "[occ][guard]") {
    // Nobody writes to the pipe: to read it takes for ever.
    const Scratch folder;
    const fs::path pipe = folder / "endless.step";
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    int calls = 0;
    const base::Progress cancel = [&](std::string_view, double) { return ++calls < 4; };
    CHECK_THROWS_AS(occ::read_cad_guarded(pipe, reader(), {.progress = cancel}), base::Cancelled);
    CHECK_FALSE(has_workers());
}

TEST_CASE("a reader process starts before there are threads", "[occ][guard][errors]") {
    std::promise<void> end;
    std::thread other([&] { end.get_future().wait(); });
    CHECK_THROWS_AS(occ::ReaderProcess(), base::InvalidArgument);
    end.set_value();
    other.join();
}
