#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/base/memory.h>
#include <patchwright/base/parallel.h>
#include <patchwright/convert/convert.h>
#include <patchwright/mesh/obj.h>

#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>

using namespace patchwright;

namespace {

const std::filesystem::path samples = PATCHWRIGHT_SAMPLES_DIR;

/// A folder that is empty at first and gone at last.
class Folder {
  public:
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "patchwright_XXXXXX").string();
        REQUIRE(mkdtemp(name.data()) != nullptr);
        path_ = name;
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    [[nodiscard]] std::filesystem::path operator/(const char* name) const { return path_ / name; }
    [[nodiscard]] std::size_t size() const {
        return std::size_t(std::distance(std::filesystem::directory_iterator(path_), {}));
    }

  private:
    std::filesystem::path path_;
};

std::string content(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

const convert::Source& wing() {
    static const convert::Source source = convert::read_source(samples / "wing" / "wing.step");
    return source;
}

/// The fits of several cages miss this.
convert::ConvertOptions out_of_reach() {
    return {.tolerance_mm = 1e-7 * wing().input.diagonal,
            .method = cage::Method::Aligned,
            .max_levels = 0};
}

}  // namespace

TEST_CASE("a wing becomes one met solid, and nothing else is left", "[convert][oracle]") {
    const Folder folder;
    const auto file = folder / "wing.step";
    const double tolerance = 1e-3 * wing().input.diagonal;
    const convert::Conversion done = convert::convert(wing(), file, {.tolerance_mm = tolerance});
    REQUIRE(done.kept.has_value());
    CHECK_FALSE(done.time_limit_reached);
    const convert::Attempt& best = done.attempts[*done.kept];
    CHECK(best.verdict.met());
    CHECK(best.kind == convert::CageKind::Sections);
    CHECK(best.deviation.output_to_input.max <= tolerance);
    CHECK(folder.size() == 1);
    // The file holds what was measured.
    const convert::Source back = convert::read_source(file);
    CHECK(back.figures.closed);
    CHECK(back.figures.volume == Approx(wing().figures.volume).epsilon(2e-3));
    CHECK(back.figures.faces == best.patches.count);
    CHECK(content(file).find("FILE_NAME('wing'") != std::string::npos);
}

TEST_CASE("bytes do not depend on the number of threads", "[convert]") {
    const Folder folder;
    const double tolerance = 1e-3 * wing().input.diagonal;
    std::string bytes[2];
    for (const int threads : {1, 2}) {
        base::set_thread_count(threads);
        convert::convert(wing(), folder / "a.step", {.tolerance_mm = tolerance});
        bytes[threads - 1] = content(folder / "a.step");
    }
    base::set_thread_count(0);
    CHECK((bytes[0] == bytes[1]));  // in brackets: else a failure prints both files
}

TEST_CASE("a time limit delivers the best result so far, or nothing", "[convert]") {
    const Folder folder;
    const auto file = folder / "wing.step";
    // No fit reaches this; each level brings some more.
    const convert::ConvertOptions options{.tolerance_mm = 1e-7 * wing().input.diagonal};
    const convert::Conversion none =
        convert::convert(wing(), file, options, base::Budget(base::Budget::Seconds(0.0)));
    CHECK(none.time_limit_reached);
    CHECK_FALSE(none.kept.has_value());
    CHECK(folder.size() == 0);

    const convert::Conversion some =
        convert::convert(wing(), file, options, base::Budget(base::Budget::Seconds(3.0)));
    CHECK(some.time_limit_reached);
    if (some.kept) {  // as long as a first level takes less on this machine
        CHECK_FALSE(some.attempts[*some.kept].verdict.met());
        CHECK(folder.size() == 1);
    }
}

TEST_CASE("memory used up after the first attempt delivers that one", "[convert]") {
    const Folder folder;
    const convert::ConvertOptions options{.tolerance_mm = 1e-7 * wing().input.diagonal,
                                          .max_levels = 0};
    bool was_under_way = false;
    const base::Budget later(std::nullopt, [&](std::string_view stage, double) {
        if (stage == "attempt 2, fit") {
            was_under_way = base::MayRunOutOfMemory::is_under_way();
            throw std::bad_alloc();
        }
        return true;
    });
    const convert::Conversion done = convert::convert(wing(), folder / "a.step", options, later);
    REQUIRE(done.notices.size() == 1);
    CHECK(done.notices[0] == "attempt 2 ran out of memory and was given up");
    CHECK(was_under_way);
    CHECK_FALSE(base::MayRunOutOfMemory::is_under_way());
    REQUIRE(done.kept == 0u);
    REQUIRE(done.attempts.size() == 1);
    CHECK(done.attempts[0].measured);
    CHECK(folder.size() == 1);
    CHECK(convert::read_source(folder / "a.step").figures.closed);

    bool bounding = false;
    const base::Budget last(std::nullopt, [&](std::string_view stage, double) {
        bounding = stage == "bound";
        if (bounding) throw std::bad_alloc();
        return true;
    });
    const convert::Conversion unbounded =
        convert::convert(wing(), folder / "a.step", {.tolerance_mm = 1.0}, last);
    CHECK(bounding);
    REQUIRE(unbounded.kept);
    CHECK_FALSE(unbounded.attempts[*unbounded.kept].deviation.output_to_input.bound);
    CHECK(unbounded.attempts[*unbounded.kept].verdict.met());
    CHECK(folder.size() == 1);

    const base::Budget at_once(std::nullopt, [&](std::string_view, double) -> bool {
        CHECK_FALSE(base::MayRunOutOfMemory::is_under_way());
        throw std::bad_alloc();
    });
    CHECK_THROWS_AS(convert::convert(wing(), folder / "b.step", options, at_once), std::bad_alloc);
    CHECK(folder.size() == 1);
}

TEST_CASE("of attempts whose fits miss only the best one is measured and written", "[convert]") {
    const Folder folder;
    const convert::Conversion done = convert::convert(wing(), folder / "a.step", out_of_reach());
    REQUIRE(done.attempts.size() > 1);
    for (std::size_t i = 0; i < done.attempts.size(); ++i) {
        const convert::Attempt& attempt = done.attempts[i];
        CHECK(attempt.measured == (i == done.kept));
        CHECK((attempt.output != nullptr) == (i == done.kept));
        CHECK_FALSE(attempt.verdict.met());
        CHECK_FALSE(attempt.misses.empty());
    }
    CHECK(done.attempts[*done.kept].patches.count > 0);
    CHECK(folder.size() == 1);
}

TEST_CASE("memory used up while the best attempt is measured delivers another one", "[convert]") {
    const Folder folder;
    bool used_up = false;
    const base::Budget once(std::nullopt, [&](std::string_view stage, double) {
        if (!used_up && stage.ends_with("deviation")) {
            used_up = true;
            throw std::bad_alloc();
        }
        return true;
    });
    const convert::Conversion done =
        convert::convert(wing(), folder / "a.step", out_of_reach(), once);
    CHECK(used_up);
    REQUIRE(done.kept);
    CHECK(done.attempts[*done.kept].measured);
    REQUIRE_FALSE(done.notices.empty());
    CHECK(done.notices.back().ends_with("ran out of memory and was given up"));
    CHECK(folder.size() == 1);
}

TEST_CASE("cancelling leaves the old file alone", "[convert]") {
    const Folder folder;
    const auto file = folder / "wing.step";
    std::ofstream(file) << "old";
    int calls = 0;
    const base::Budget budget(std::nullopt, [&](std::string_view, double) { return ++calls < 20; });
    CHECK_THROWS_AS(convert::convert(wing(), file, {.tolerance_mm = 1.0}, budget), base::Cancelled);
    CHECK(content(file) == "old");
    CHECK(folder.size() == 1);
}

TEST_CASE("a missed tolerance is a verdict, not an error", "[convert]") {
    const Folder folder;
    const convert::Conversion done =
        convert::convert(wing(), folder / "wing.step",
                         {.tolerance_mm = 1e-9 * wing().input.diagonal,
                          .cage = mesh::read_obj(samples / "wing" / "wing_cage.obj").cage,
                          .max_levels = 0});
    REQUIRE(done.attempts.size() == 1);
    CHECK_FALSE(done.attempts.front().verdict.met());
    CHECK(folder.size() == 1);
}

TEST_CASE("a fit by itself has a verdict on its own samples", "[convert]") {
    const double tolerance = 1e-3 * wing().input.diagonal;
    const convert::Conversion done = convert::fit_only(wing(), {.tolerance_mm = tolerance});
    CHECK(done.attempts.front().verdict.met());
    CHECK(done.attempts.front().verdict.conditions.size() == 2);
    CHECK(done.attempts.front().fit.levels.back().largest() <= tolerance);
}
