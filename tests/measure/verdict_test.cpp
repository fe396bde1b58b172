#include <patchwright/base/error.h>
#include <patchwright/measure/verdict.h>

#include <catch2/catch.hpp>

#include <functional>

using namespace patchwright;
using measure::Requirement;
using measure::VerdictFigures;

namespace {

/// A conversion that fulfils every condition: 0.05 mm on a diagonal of 1 m, tolerance 0.1 mm.
VerdictFigures good() {
    return {.tolerance_mm = 0.1,
            .diagonal_mm = 1000.0,
            .output_to_input_mm = measure::Worst{0.05, std::nullopt},
            .input_to_output_mm = measure::Worst{0.052, geom::Vec3(1, 2, 3)},
            .lost_sharp_curves = measure::Failures{},
            .free_edges = 0,
            .valid = true,
            .bodies = 1,
            .bodies_of_input = 1,
            .volume_mm3 = 5.0,
            .area_mm2 = 30.0,
            .fold_rad = measure::Worst{0.7, std::nullopt},
            .kink_rad = measure::Worst{0.017, std::nullopt},
            .self_intersecting_faces = measure::Failures{},
            .patches = 6,
            .closed = true};
}

}  // namespace

TEST_CASE("a result that fulfils every condition is met and says what it is", "[verdict]") {
    const measure::Verdict verdict = measure::assess(good());
    CHECK(verdict.met());
    CHECK(verdict.worst() == nullptr);
    CHECK(verdict.conditions.size() == 10);
    for (const auto& c : verdict.conditions) CHECK(c.remedy.empty());
    CHECK(verdict.sentence(base::LengthUnit::Millimetre) ==
          "met 1e-4: one closed valid solid, 6 patches, 5.2e-5 of the diagonal");
}

TEST_CASE("every condition can fail by itself, with its name, place and remedy", "[verdict]") {
    const geom::Vec3 place(25.4, 0.0, -50.8);
    struct Case {
        Requirement requirement;
        std::function<void(VerdictFigures&)> spoil;
        const char* text;
        bool has_place = true;
    };
    const Case cases[] = {
        {Requirement::DistanceToInput,
         [&](auto& f) {
             f.output_to_input_mm = measure::Worst{0.11, place};
         },
         "the output is 1.1e-4 of the diagonal from the input (limit 1e-4)"},
        {Requirement::DistanceFromInput,
         [&](auto& f) {
             f.input_to_output_mm = measure::Worst{0.2, place};
         },
         "the input is 2e-4 of the diagonal from the output"},
        {Requirement::SharpCurves,
         [&](auto& f) {
             f.lost_sharp_curves = measure::Failures{2, place};
         },
         "2 long sharp curves are lost"},
        {Requirement::Closed, [](auto& f) { f.free_edges = 1; }, "one free edge", false},
        {Requirement::Valid, [](auto& f) { f.valid = false; }, "not valid", false},
        {Requirement::Bodies, [](auto& f) { f.bodies = 2; }, "2 bodies where the input has 1",
         false},
        {Requirement::Volume, [](auto& f) { f.volume_mm3 = 0.0; }, "the volume is 0", false},
        {Requirement::Volume,
         [](auto& f) {
             f.volume_mm3 = 4e-8;  // a film of 0.4e-7 mm and 1 mm^2 on each side
             f.area_mm2 = 2.0;
         },
         "the volume is 4e-08", false},
        {Requirement::Area,
         [](auto& f) {
             f.volume_mm3.reset();
             f.area_mm2 = 1e-8;  // a thread of 1e-7 mm and a tenth of a millimetre
         },
         "the area is 1e-08", false},
        {Requirement::Folds,
         [&](auto& f) {
             f.fold_rad = measure::Worst{3.0, place};
         },
         "normals differ by 172 degrees"},
        {Requirement::Normals,
         [&](auto& f) {
             f.normal_angle_rad = measure::Worst{0.02, place};
             f.normal_tolerance_rad = 0.01;
         },
         "normals differ by 1.15 degrees (limit 0.573)"},
        {Requirement::Kinks,
         [&](auto& f) {
             f.kink_rad = measure::Worst{0.02, place};
         },
         "a kink of 1.15 degrees"},
        {Requirement::SelfIntersections,
         [&](auto& f) {
             f.self_intersecting_faces = measure::Failures{1, place};
         },
         "one face intersects itself"},
        {Requirement::GridCells,
         [&](auto& f) {
             f.bad_grid_cells = measure::Failures{51, place};
         },
         "51 folded or negative cells"},
        {Requirement::Designs,
         [&](auto& f) {
             f.missed_designs = measure::Failures{2, {}};
         },
         "2 designs miss", false},
    };
    for (const Case& one : cases) {
        INFO(measure::name_of(one.requirement));
        VerdictFigures figures = good();
        one.spoil(figures);
        const measure::Verdict verdict = measure::assess(figures);
        CHECK_FALSE(verdict.met());
        REQUIRE(verdict.worst() != nullptr);
        CHECK(verdict.worst()->requirement == one.requirement);
        CHECK(measure::excess(*verdict.worst()) > 1.0);
        CHECK_FALSE(verdict.worst()->remedy.empty());
        const std::string sentence = verdict.sentence(base::LengthUnit::Inch);
        CHECK(sentence.find("MISSED: ") == 0);
        CHECK(sentence.find(one.text) != std::string::npos);
        CHECK(sentence.find("; try ") != std::string::npos);
        CHECK((sentence.find("at (1, 0, -2)") != std::string::npos) == one.has_place);
        CHECK(measure::better(measure::assess(good()), verdict));
        CHECK_FALSE(measure::better(verdict, measure::assess(good())));
    }
}

TEST_CASE("limits themselves are met", "[verdict]") {
    VerdictFigures figures = good();
    figures.output_to_input_mm->value = 0.1;
    figures.fold_rad->value = measure::fold_limit_rad;
    figures.kink_rad->value = measure::kink_limit_rad;
    CHECK(measure::assess(figures).met());
}

TEST_CASE("what was not measured is no condition", "[verdict]") {
    const measure::Verdict verdict = measure::assess({.valid = true});
    CHECK(verdict.met());
    CHECK(verdict.conditions.size() == 1);
    CHECK_FALSE(verdict.deviation_rel.has_value());
    CHECK_THROWS_AS(measure::assess({.output_to_input_mm = measure::Worst{}}),
                    base::InvalidArgument);
}

TEST_CASE("the better of two results is valid, misses less, is nearer", "[verdict]") {
    VerdictFigures invalid = good(), kinked = good(), far = good(), farther = good();
    invalid.valid = false;
    kinked.kink_rad->value = 1.0;
    far.output_to_input_mm->value = 0.12;
    farther.output_to_input_mm->value = 0.5;
    const auto better = [](const VerdictFigures& a, const VerdictFigures& b) {
        return measure::better(measure::assess(a), measure::assess(b));
    };
    CHECK(better(farther, invalid));
    CHECK(better(far, farther));
    CHECK(better(far, kinked));
    CHECK(better(farther, kinked));
    // A fold within a near result weighs less than three times the distance, and more than a tenth.
    VerdictFigures folded = far, farther_by_a_tenth = good();
    folded.fold_rad->value = 2.0;
    farther_by_a_tenth.output_to_input_mm->value = 1.1 * far.output_to_input_mm->value;
    CHECK(better(folded, farther));
    CHECK(better(farther_by_a_tenth, folded));
    VerdictFigures nearer = good();
    nearer.input_to_output_mm->value = 0.01;
    CHECK_FALSE(better(good(), nearer));
}

TEST_CASE("a refit that misses is told of what refits have", "[verdict]") {
    VerdictFigures figures = good();
    figures.keeps_cage = true;
    figures.output_to_input_mm->value = 1.0;
    figures.fold_rad->value = 2.0;
    figures.free_edges = 1;
    for (const auto& c : measure::assess(figures).conditions) {
        if (c.met) continue;
        CHECK(c.remedy.find("convert") != std::string::npos);
        CHECK(c.remedy.find("--cage") == std::string::npos);
        CHECK(c.remedy.find("--target-faces") == std::string::npos);
    }
}

TEST_CASE("a run that the time limit ended is told to take longer", "[verdict]") {
    VerdictFigures figures = good();
    figures.output_to_input_mm->value = 1.0;
    figures.stopped_by_time_limit = true;
    CHECK(measure::assess(figures).worst()->remedy.find("--time-limit") != std::string::npos);
}
