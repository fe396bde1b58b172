// Bodies around an axis that end in tips, as the kernel makes them.
#include "occ/turned.h"

#include <patchwright/cage/make_cage.h>
#include <patchwright/fit/fit.h>
#include <patchwright/occ/cad_reference.h>

#include <catch2/catch.hpp>

#include <array>
#include <string>
#include <vector>

using namespace patchwright;

TEST_CASE("a body around an axis may end in a tip, which is a corner of its cage",
          "[layout][oracle]") {
    struct Case {
        std::string ends;
        std::vector<std::array<double, 2>> profile;
        int tips;
    };
    const std::vector<Case> cases{
        {"ends in a tip and on the axis", {{0, 0}, {200, 0}, {250, 600}, {0, 1500}}, 1},
        {"ends in a tip and in a tip", {{0, 0}, {250, 500}, {250, 1000}, {0, 1500}}, 2},
        {"ends on the axis and on the axis",
         {{0, 0}, {200, 0}, {250, 600}, {250, 900}, {0, 900}},
         0}};
    for (const Case& body : cases) {
        const occ::CadReference reference(test::turned(body.profile));
        const auto made = cage::make_cage(reference);
        REQUIRE(made.layout.size() == 1);
        INFO(made.layout[0]);
        CHECK(made.layout[0].rfind("body around an axis: 16 lines", 0) == 0);
        CHECK(made.layout[0].find(body.ends) != std::string::npos);
        const mesh::CageSummary summary = mesh::summarise(*made.cage.topology);
        CHECK(made.cage.topology->is_closed());
        CHECK(made.cage.topology->all_quads());
        CHECK(summary.corners == body.tips);
        // Four at the corners of each end's square.
        CHECK(summary.extraordinary == 8 + body.tips);
        const double tolerance = 1e-3 * reference.bounds().diagonal();
        const fit::FitResult fitted = fit::fit(made.cage, reference, {.tolerance_mm = tolerance});
        CHECK(fitted.within_tolerance);
        CHECK(fitted.levels[std::size_t(fitted.best_level)].folded == 0);
    }
}
