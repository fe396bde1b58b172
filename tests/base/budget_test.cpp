#include <patchwright/base/budget.h>
#include <patchwright/base/error.h>

#include <catch2/catch.hpp>

using namespace patchwright;
using Seconds = base::Budget::Seconds;

TEST_CASE("a budget without a limit never ends work", "[base]") {
    const base::Budget budget;
    CHECK_FALSE(budget.is_used_up());
    CHECK_NOTHROW(base::report_progress(budget.limited(), "fit", 0.5));
}

TEST_CASE("a budget that is used up ends limited work only", "[base]") {
    int calls = 0;
    const base::Budget budget(Seconds(0.0), [&](std::string_view, double) { return ++calls > 0; });
    CHECK(budget.is_used_up());
    CHECK_THROWS_AS(base::report_progress(budget.limited(), "fit", 0.5), base::TimeLimitReached);
    CHECK(calls == 0);
    CHECK_NOTHROW(base::report_progress(budget.unlimited(), "check", 0.5));
    CHECK(calls == 1);
}

TEST_CASE("a budget with another callback keeps its limit", "[base]") {
    int first = 0, second = 0;
    const base::Budget budget(Seconds(1e9), [&](std::string_view, double) { return ++first > 0; });
    const base::Budget other = budget.with([&](std::string_view, double) { return ++second > 0; });
    CHECK_NOTHROW(base::report_progress(other.limited(), "fit", 0.5));
    CHECK(first == 0);
    CHECK(second == 1);
    CHECK(other.limit() == budget.limit());
    CHECK(base::Budget(Seconds(0.0)).with({}).is_used_up());
}

TEST_CASE("cancelling is not running out of time", "[base]") {
    const base::Budget budget(Seconds(1e9), [](std::string_view, double) { return false; });
    CHECK_THROWS_AS(base::report_progress(budget.limited(), "fit", 0.5), base::Cancelled);
}
