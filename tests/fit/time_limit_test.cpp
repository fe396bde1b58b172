#include "support/analytic_references.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/fit_parts.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

using namespace patchwright;

namespace {

constexpr int never = std::numeric_limits<int>::max();

/// A callback whose calls from number `first` on throw `E`; counts calls.
template <class E>
base::Progress throwing_from(int first, int* calls) {
    *calls = 0;
    return [=](std::string_view, double) {
        if ((*calls)++ >= first) throw E();
        return true;
    };
}

/// Takes a few levels.
fit::FitResult fit_sphere(int max_levels, base::Progress progress) {
    return fit::fit(test::cube(2.0), test::Sphere(1.0),
                    {.tolerance_mm = 1e-4,
                     .refinement = fit::RefinementScope::Global,
                     .max_levels = max_levels,
                     .progress = std::move(progress)});
}

}  // namespace

TEST_CASE("a fit that the time limit ends returns the best level so far", "[fit]") {
    int calls = 0;
    const auto level = [&](int count) {
        fit_sphere(count - 1, throwing_from<base::TimeLimitReached>(never, &calls));
        return calls;
    };
    const int first = level(1), second = level(2);
    REQUIRE(second > first);
    for (const int last : {first, (first + second) / 2, second - 1}) {
        const auto cut = fit_sphere(3, throwing_from<base::TimeLimitReached>(last, &calls));
        const auto whole = fit_sphere(0, {});
        CHECK(cut.stopped_by_time_limit);
        CHECK_FALSE(whole.stopped_by_time_limit);
        REQUIRE(cut.levels.size() == 1);
        CHECK(cut.cage.points == whole.cage.points);
        CHECK(cut.levels[0].max_mm == whole.levels[0].max_mm);
    }
    const auto of_two = fit_sphere(3, throwing_from<base::TimeLimitReached>(second, &calls));
    CHECK(of_two.levels.size() == 2);
    CHECK(of_two.cage.points == fit_sphere(1, {}).cage.points);
}

TEST_CASE("the first level counts as far as it came within the time limit", "[fit]") {
    int calls = 0;
    const auto whole = fit_sphere(0, throwing_from<base::TimeLimitReached>(never, &calls));
    const int all = calls;
    const auto cut_at = [&](int first) {
        auto cut = fit_sphere(0, throwing_from<base::TimeLimitReached>(first, &calls));
        CHECK(cut.stopped_by_time_limit);
        REQUIRE(cut.levels.size() == 1);
        CHECK(cut.levels[0].samples == whole.levels[0].samples);
        return cut;
    };
    const auto none = cut_at(0), half = cut_at(all / 2), last = cut_at(all - 1);
    CHECK(none.cage.points == test::cube(2.0).points);
    CHECK(none.levels[0].projections == 0);
    CHECK(half.levels[0].rms_mm < 0.5 * none.levels[0].rms_mm);
    CHECK(half.levels[0].projections < last.levels[0].projections);
    CHECK(last.levels[0].projections < whole.levels[0].projections);
}

TEST_CASE("anything else that the callback throws ends a fit without a result", "[fit][errors]") {
    struct Other {};
    int calls = 0;
    fit_sphere(0, throwing_from<Other>(never, &calls));
    const int first = calls;
    CHECK_THROWS_AS(fit_sphere(3, throwing_from<Other>(0, &calls)), Other);
    CHECK_THROWS_AS(fit_sphere(3, throwing_from<Other>(first + 1, &calls)), Other);
}

TEST_CASE("fits of several cages are one", "[fit]") {
    const test::Sphere sphere(1.0);
    const mesh::Cage cube = test::cube(2.0);
    const fit::FitOptions options{.max_levels = 0};
    const fit::FitResult fitted = fit::fit(cube, sphere, options);
    const fit::FitResult given = fit::measure_given(cube, sphere, options);
    CHECK(fitted.levels[0].projections > 0);
    // Limit points of the cube's vertices are half as far from the centre as these.
    REQUIRE(given.levels.size() == 1);
    CHECK(given.cage.points == cube.points);
    CHECK(given.levels[0].max_mm > 1.0 - std::sqrt(0.75) - 1e-12);
    fit::FitResult cut = given;
    cut.stopped_by_time_limit = true;
    const fit::FitResult both = fit::joined({fitted, cut});
    CHECK(both.stopped_by_time_limit);
    CHECK(both.levels.back().max_mm == std::max(fitted.levels[0].max_mm, given.levels[0].max_mm));
    CHECK(both.levels.back().vertices == 16);
    CHECK(both.cage.topology->face_count() == 12);
    CHECK_FALSE(fit::joined({fitted, given}).stopped_by_time_limit);
    CHECK_THROWS_AS(fit::joined({}), base::InvalidArgument);
}
