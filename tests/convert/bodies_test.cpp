// Models of several bodies, each of which is converted by itself.
#include "convert/bodies.h"

#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/mesh/parts.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/patch/extract.h>

#include <catch2/catch.hpp>

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <thread>

using namespace patchwright;

namespace {

/// Two sharp cubes with edges of 2 mm, one of them moved along x and a little across.
convert::Source cubes(double apart) {
    mesh::TopologyInput tags;
    for (const auto& face : test::cube_faces) {
        for (std::size_t i = 0; i < 4; ++i)
            if (face[i] < face[(i + 1) % 4])
                tags.creases.push_back({face[i], face[(i + 1) % 4], mesh::infinite_sharpness});
    }
    const mesh::Cage one = test::cube(2.0, tags);
    mesh::Cage other = one;
    other.points.rowwise() += Eigen::RowVector3d(apart, 0.1, 0.2);
    const occ::CadModel model = occ::assemble(patch::extract(mesh::joined({one, other})).patches);
    convert::Source source{.model = model,
                           .cad = std::make_shared<const occ::CadReference>(model),
                           .figures = convert::solid_figures("cubes", model),
                           .bodies = 2};
    source.input.file = "cubes";
    source.input.diagonal = source.cad->bounds().diagonal();
    return source;
}

/// One sticks in the other.
convert::Source crossing_cubes() { return cubes(1.2); }

class OutputFile {
  public:
    explicit OutputFile(const std::string& name)
        : path_(std::filesystem::temp_directory_path() /
                ("patchwright_" + std::to_string(getpid()) + "_" + name)) {}
    ~OutputFile() { std::filesystem::remove(path_); }
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

}  // namespace

TEST_CASE("bodies are sources of their own, of the model's size", "[convert]") {
    const convert::Source source = crossing_cubes();
    convert::ConvertOptions options{.target_faces = 100, .samples = 20000};
    CHECK(convert::by_bodies(source, options));
    const auto bodies = convert::bodies_of(source, options, {});
    REQUIRE(bodies.size() == 2);
    for (const convert::Body& body : bodies) {
        CHECK(body.source.figures.closed);
        CHECK(body.source.figures.faces == 6);
        CHECK(body.source.figures.volume == Approx(8.0));
        CHECK(body.source.cad->features().corners.size() == 8);
        CHECK(body.source.cad->size() == Approx(source.cad->size()));
        CHECK(body.source.cad->bounds().diagonal() == Approx(std::sqrt(12.0)));
        CHECK(body.options.samples == 10000);
        CHECK(body.options.target_faces == 50);
    }
    // Groups of both cages go by the model's faces.
    CHECK(bodies[0].source.cad->face_names() != bodies[1].source.cad->face_names());
    options.cage = test::cube(2.0);
    CHECK_FALSE(convert::by_bodies(source, options));
}

TEST_CASE("each body has its own attempts, which together are the model's", "[convert]") {
    const convert::Source source = crossing_cubes();
    const OutputFile file("cubes.step");
    const convert::Conversion done = convert::convert(source, file.path(), {.tolerance_mm = 1e-3});
    REQUIRE(done.bodies.size() == 2);
    REQUIRE(done.attempts.size() == 1);
    CHECK(done.kept == 0);
    int faces = 0;
    for (const convert::Conversion& body : done.bodies) {
        REQUIRE(body.kept);
        const convert::Attempt& best = body.attempts[*body.kept];
        CHECK(best.verdict.met());
        CHECK_FALSE(best.file);
        faces += best.fitted.topology->face_count();
    }
    const convert::Attempt& whole = done.attempts.front();
    CHECK(whole.verdict.met());
    CHECK(whole.fitted.topology->face_count() == faces);
    CHECK(whole.layout.size() == 2);
    CHECK(whole.shape.solid.solids == 2);
    CHECK(whole.shape.solid.volume == Approx(16.0));
    // The same as the first cube alone.
    const auto first = std::move(convert::bodies_of(source, {.tolerance_mm = 1e-3}, {}).front());
    const convert::Conversion alone =
        convert::convert(first.source, file.path(), {.tolerance_mm = 1e-3});
    CHECK(alone.attempts.front().fitted.points == done.bodies[0].attempts.front().fitted.points);
}

TEST_CASE("bodies that are apart and meet are measured together only", "[convert]") {
    const convert::Source source = cubes(3.5);
    const OutputFile file("apart.step");
    const convert::Conversion done = convert::convert(source, file.path(), {.tolerance_mm = 1e-3});
    REQUIRE(done.bodies.size() == 2);
    for (const convert::Conversion& body : done.bodies) CHECK_FALSE(body.attempts.front().measured);
    REQUIRE(done.attempts.size() == 1);
    CHECK(done.attempts.front().verdict.met());
    CHECK(done.attempts.front().shape.solid.solids == 2);
}

TEST_CASE("folds are looked for all over where some bodies were not measured", "[convert]") {
    const convert::Source source = crossing_cubes();
    const OutputFile file("folds.step");
    const auto samples = [&](const base::Budget& budget) {
        const auto done = convert::convert(source, file.path(), {.tolerance_mm = 1e-3}, budget);
        return done.attempts.front().folds.samples;
    };
    // The limit is reached while the first body is measured.
    constexpr auto limit = std::chrono::seconds(2);
    const auto wait = [&](std::string_view stage, double) {
        if (stage == "body 1, folds") std::this_thread::sleep_for(limit);
        return true;
    };
    CHECK(samples(base::Budget(limit, wait)) == samples(base::Budget()));
}

TEST_CASE("bodies that there is no time for are taken as their cages were made", "[convert]") {
    const convert::Source source = crossing_cubes();
    const OutputFile file("cut.step");
    // The time limit counts in calls.
    int calls = 0, last = 0;
    const auto count = [&](std::string_view, double) {
        ++calls;
        if (last > 0 && calls > last) throw base::TimeLimitReached();
        return true;
    };
    const auto run = [&] {
        calls = 0;
        return convert::fit_only(source, {.tolerance_mm = 1e-6}, base::Budget({}, count));
    };
    const convert::Conversion whole = run();
    REQUIRE(whole.attempts.size() == 1);
    CHECK_FALSE(whole.attempts.front().stopped_by_time_limit);
    const int all = calls;
    // In the fit of the second body, which is the last thing done.
    last = all - 1;
    const convert::Conversion cut = run();
    CHECK(cut.attempts.front().stopped_by_time_limit);
    CHECK(cut.attempts.front().fitted.topology->face_count() ==
          whole.attempts.front().fitted.topology->face_count());
    // Without all cages there is nothing.
    last = 1;
    CHECK_THROWS_AS(run(), base::TimeLimitReached);
}
