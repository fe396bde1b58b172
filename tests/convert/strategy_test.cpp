#include "support/cages.h"

#include <patchwright/convert/convert.h>

#include <catch2/catch.hpp>

using namespace patchwright;
using convert::Attempt;
using convert::AttemptPlan;
using convert::CageKind;
using measure::Requirement;

namespace {

constexpr double diagonal = 1000.0, tolerance = 0.1;

convert::ConvertOptions made() { return {.tolerance_mm = tolerance}; }

/// A closed solid of one body, as far as figures go.
convert::Source solid() {
    convert::Source source;
    source.input.diagonal = diagonal;
    source.figures.closed = true;
    source.bodies = 1;
    return source;
}

/// An attempt of this plan whose distance is so many tolerances, else perfect.
Attempt attempt(const AttemptPlan& plan, CageKind kind, double tolerances) {
    Attempt a{.plan = plan, .kind = kind, .cage = test::cube(1.0)};
    a.fit.tolerance = tolerance;
    a.fit.levels.push_back({.max_mm = tolerances * tolerance});
    a.shape.solid = {.solids = 1, .faces = 6, .closed = true, .valid = true, .volume = 1.0};
    a.shape.bodies = 1;
    a.deviation.output_to_input.max = tolerances * tolerance;
    a.deviation.output_to_input.at = geom::Vec3(1, 2, 3);
    a.deviation.output_to_input.worst = {{geom::Vec3(1, 2, 3), 0, tolerances * tolerance}};
    a.deviation.long_sharp.emplace();
    a.verdict = convert::assess(a, solid(), tolerance);
    return a;
}

Attempt folded(Attempt a) {
    a.folds.worst = measure::Fold{.angle_rad = 3.0};
    a.verdict = convert::assess(a, solid(), tolerance);
    return a;
}

Attempt next_of(const std::vector<Attempt>& attempts, CageKind kind, double tolerances) {
    const auto plan = convert::choose_next(attempts, made(), diagonal);
    REQUIRE(plan.has_value());
    return attempt(*plan, kind, tolerances);
}

Requirement missed(const Attempt& a) {
    const measure::Verdict verdict = convert::assess(a, solid(), tolerance);
    int count = 0;
    for (const auto& c : verdict.conditions) count += c.met ? 0 : 1;
    REQUIRE(count == 1);
    return verdict.worst()->requirement;
}

}  // namespace

TEST_CASE("figures of the check and of the fit both count", "[convert]") {
    const Attempt good = attempt({}, CageKind::Sections, 0.5);
    CHECK(good.verdict.met());
    Attempt a = good;
    a.deviation.output_to_input.max = 1.1 * tolerance;
    CHECK(missed(a) == Requirement::DistanceToInput);
    a = good;
    a.deviation.input_to_output.max = 1.1 * tolerance;
    CHECK(missed(a) == Requirement::DistanceFromInput);
    a = good;
    a.fit.levels.back().max_mm = 1.1 * tolerance;
    CHECK(missed(a) == Requirement::DistanceToInput);
    a = good;
    a.fit.levels.back().curve_max_mm = 1.1 * tolerance;
    CHECK(missed(a) == Requirement::DistanceToInput);
    a = good;
    a.fit.levels.back().reverse_max_mm = 1.1 * tolerance;
    a.fit.levels.back().reverse_max_at = geom::Vec3(4, 5, 6);
    CHECK(missed(a) == Requirement::DistanceFromInput);
    CHECK(*convert::assess(a, solid(), tolerance).worst()->at == geom::Vec3(4, 5, 6));
}

TEST_CASE("every figure of a shape has its condition", "[convert]") {
    const Attempt good = attempt({}, CageKind::Sections, 0.5);
    Attempt a = good;
    a.deviation.long_sharp->missed.push_back({.length = 50.0, .distance = 1.0});
    CHECK(missed(a) == Requirement::SharpCurves);
    a = good;
    a.shape.solid.free_edges = 2;
    CHECK(missed(a) == Requirement::Closed);
    a = good;
    a.shape.solid.valid = false;
    CHECK(missed(a) == Requirement::Valid);
    a = good;
    a.shape.bodies = 2;
    CHECK(missed(a) == Requirement::Bodies);
    a = good;
    a.shape.solid.volume = -1.0;
    CHECK(missed(a) == Requirement::Volume);
    a = good;
    a.folds.worst = measure::Fold{.angle_rad = 3.0};
    CHECK(missed(a) == Requirement::Folds);
    a = good;
    a.shape.continuity.max_kink_rad = 0.1;
    CHECK(missed(a) == Requirement::Kinks);
    a = good;
    a.shape.self_intersections.emplace_back();
    CHECK(missed(a) == Requirement::SelfIntersections);
}

TEST_CASE("an open model asks neither for closed results nor for bodies", "[convert]") {
    Attempt a = attempt({}, CageKind::Sections, 0.5);
    a.shape.solid.free_edges = 2;
    a.shape.bodies = 2;
    convert::Source open = solid();
    open.figures.closed = false;
    CHECK(convert::assess(a, open, tolerance).met());
}

TEST_CASE("nothing is tried after success, nor after a given cage", "[convert]") {
    const auto plan = convert::choose_next({}, made(), diagonal);
    REQUIRE(plan.has_value());
    CHECK_FALSE(plan->given);
    CHECK(plan->cage.tolerance_rel == Approx(tolerance / diagonal));
    CHECK_FALSE(convert::choose_next({attempt(*plan, CageKind::Sections, 0.9)}, made(), diagonal));

    convert::ConvertOptions options = made();
    options.cage = test::cube(1.0);
    const auto given = convert::choose_next({}, options, diagonal);
    REQUIRE(given.has_value());
    CHECK(given->given);
    CHECK_FALSE(convert::choose_next({attempt(*given, CageKind::Given, 5.0)}, options, diagonal));
}

TEST_CASE("cages along sections are fitted freely, get finer while that helps, then remeshed",
          "[convert]") {
    std::vector<Attempt> attempts{
        attempt(*convert::choose_next({}, made(), diagonal), CageKind::Sections, 3.0)};
    attempts.push_back(next_of(attempts, CageKind::Sections, 2.5));
    CHECK_FALSE(attempts.back().plan.preserve_parametrisation);
    CHECK(attempts.back().plan.same_cage(attempts.front().plan));
    attempts.push_back(next_of(attempts, CageKind::Sections, 1.3));
    CHECK(attempts.back().plan.preserve_parametrisation);
    CHECK(attempts.back().plan.cage.fineness == 2.0);
    attempts.push_back(next_of(attempts, CageKind::Sections, 1.3));
    attempts.push_back(next_of(attempts, CageKind::Sections, 1.25));  // finer, hardly nearer
    CHECK(attempts.back().plan.cage.fineness == 4.0);
    attempts.push_back(next_of(attempts, CageKind::Sections, 1.25));
    attempts.push_back(next_of(attempts, CageKind::Remeshed, 1.2));
    CHECK(attempts.back().plan.cage.method == cage::Method::Remesh);
    CHECK(convert::choose_best(attempts) == attempts.size() - 1);
}

TEST_CASE("a shape that folds within the tolerance is fitted more closely, once", "[convert]") {
    std::vector<Attempt> attempts{
        folded(attempt(*convert::choose_next({}, made(), diagonal), CageKind::Sections, 0.5))};
    attempts.push_back(folded(next_of(attempts, CageKind::Sections, 0.5)));
    CHECK(attempts.back().plan.fit_share == 0.5);
    CHECK(attempts.back().plan.preserve_parametrisation);
    CHECK(attempts.back().plan.same_cage(attempts.front().plan));
    CHECK_FALSE(next_of(attempts, CageKind::Sections, 0.5).plan.preserve_parametrisation);
}

TEST_CASE("where only normals miss the same cage is fitted as much nearer as they need",
          "[convert]") {
    convert::ConvertOptions options = made();
    options.normal_tolerance_rad = 0.01;
    const auto off = [&](Attempt a, double times) {
        a.deviation.fairness = measure::RelativeFairness{.samples = 1};
        a.deviation.fairness->normal_angle_rad.max = times * 0.01;
        a.verdict = convert::assess(a, solid(), tolerance, options.normal_tolerance_rad);
        return a;
    };
    const Attempt good = attempt({}, CageKind::Remeshed, 0.5);
    CHECK(off(good, 0.9).verdict.met());
    CHECK(off(good, 1.1).verdict.worst()->requirement == Requirement::Normals);
    CHECK(convert::assess(good, solid(), tolerance, 0.01).met());  // not measured
    // The fourth power of the edges' length for distances, the third for normals.
    const auto eighth = convert::choose_next({off(good, 8.0)}, options, diagonal);
    REQUIRE(eighth.has_value());
    CHECK(eighth->same_cage(good.plan));
    CHECK(eighth->fit_share == Approx(1.0 / 16.0));
    // Steps do not become endless.
    Attempt nearest = good;
    nearest.plan.fit_share = 5e-4;
    const auto after = convert::choose_next({off(nearest, 1.1)}, options, diagonal);
    CHECK((!after || !after->same_cage(nearest.plan)));
    // A given cage is fitted nearer as well, but only for this.
    options.cage = test::cube(1.0);
    const Attempt given = attempt({.given = true}, CageKind::Given, 0.5);
    const auto nearer = convert::choose_next({off(given, 1.01)}, options, diagonal);
    REQUIRE(nearer.has_value());
    CHECK(nearer->given);
    CHECK(nearer->fit_share == 0.5);
    CHECK_FALSE(convert::choose_next({off(folded(given), 1.1)}, options, diagonal));
}

TEST_CASE("a fit that is nearer than the check finds it is fitted more closely", "[convert]") {
    std::vector<Attempt> attempts{
        attempt(*convert::choose_next({}, made(), diagonal), CageKind::Sections, 1.1)};
    attempts.back().fit.levels.back().max_mm = 0.9 * tolerance;
    attempts.push_back(next_of(attempts, CageKind::Sections, 0.6));
    CHECK(attempts.back().plan.fit_share == 0.5);
    CHECK(attempts.back().plan.preserve_parametrisation);
    CHECK(attempts.back().verdict.met());
}

TEST_CASE("a sharp curve that is lost is no matter of nearness", "[convert]") {
    Attempt lost = attempt(*convert::choose_next({}, made(), diagonal), CageKind::Field, 1.1);
    lost.fit.levels.back().max_mm = 0.9 * tolerance;
    CHECK(convert::choose_next({lost}, made(), diagonal)->fit_share == 0.5);
    lost.deviation.long_sharp->count = 1;
    lost.deviation.long_sharp->missed.emplace_back();
    lost.verdict = convert::assess(lost, solid(), tolerance);
    CHECK(convert::choose_next({lost}, made(), diagonal)->cage.blocks == cage::BlockWay::Faces);
}

TEST_CASE("a recognised shape that is far off is none", "[convert]") {
    AttemptPlan free = *convert::choose_next({}, made(), diagonal);
    free.preserve_parametrisation = false;
    const auto next =
        convert::choose_next({attempt(free, CageKind::Sections, 11.0)}, made(), diagonal);
    REQUIRE(next.has_value());
    CHECK(next->cage.method == cage::Method::Remesh);
    // Unless the user has asked for lines along the shape.
    convert::ConvertOptions aligned = made();
    aligned.method = cage::Method::Aligned;
    CHECK_FALSE(convert::choose_next({attempt(free, CageKind::Sections, 11.0)}, aligned, diagonal));
}

TEST_CASE("after blocks along faces come those of a field, then remeshed cages", "[convert]") {
    const AttemptPlan blocks = *convert::choose_next({}, made(), diagonal);
    const Attempt a = attempt(blocks, CageKind::Blocks, 2.0);
    std::vector<Attempt> attempts{a, next_of(std::vector{a}, CageKind::Field, 2.0)};
    CHECK(attempts.back().plan.cage.blocks == cage::BlockWay::Field);
    CHECK(attempts.back().plan.cage.method == cage::Method::Auto);
    CHECK(attempts.back().plan.cage.fineness == 1.0);
    // Those along faces have been tried.
    CHECK(convert::choose_next(attempts, made(), diagonal)->cage.blocks == cage::BlockWay::None);
    std::swap(attempts[0], attempts[1]);
    const auto next = convert::choose_next(attempts, made(), diagonal);
    REQUIRE(next.has_value());
    CHECK(next->cage.method == cage::Method::Remesh);
    CHECK(next->cage.fineness == 1.0);
    // Unless the user has asked for blocks.
    convert::ConvertOptions aligned = made();
    aligned.method = cage::Method::Aligned;
    CHECK(convert::choose_next({a}, aligned, diagonal)->cage.fineness == 2.0);
}

TEST_CASE("blocks of a field that fold get finer once, then others take their place", "[convert]") {
    std::vector<Attempt> attempts{
        folded(attempt(*convert::choose_next({}, made(), diagonal), CageKind::Field, 0.9))};
    CHECK(attempts.back().plan.cage.blocks == cage::BlockWay::Fewest);
    attempts.push_back(folded(next_of(attempts, CageKind::Field, 0.9)));
    CHECK(attempts.back().plan.cage.fineness == 2.0);
    CHECK(attempts.back().plan.fit_share == 1.0);
    CHECK(attempts.back().plan.cage.blocks == cage::BlockWay::Field);
    // Finer ones that are refused are no remeshed cage.
    CHECK(attempts.back().plan.cage.method == cage::Method::Aligned);
    const auto others = convert::choose_next(attempts, made(), diagonal);
    REQUIRE(others.has_value());
    CHECK(others->cage.blocks == cage::BlockWay::Faces);
    CHECK_FALSE(others->same_cage(attempts.front().plan));
    CHECK(others->cage.fineness == 1.0);
    CHECK(others->cage.method == cage::Method::Auto);
    // Where there are no finer ones, the same are fitted nearer, once.
    attempts.resize(1);
    attempts.back().finer_refused = true;
    attempts.push_back(folded(next_of(attempts, CageKind::Field, 0.9)));
    CHECK(attempts.back().plan.same_cage(attempts.front().plan));
    CHECK(attempts.back().plan.fit_share == 0.5);
    attempts.back().finer_refused = true;
    CHECK(convert::choose_next(attempts, made(), diagonal)->cage.blocks == cage::BlockWay::Faces);
    // What is too far off is given up at once.
    Attempt far = attempt(attempts.back().plan, CageKind::Field, 1.5);
    CHECK(convert::choose_next({far}, made(), diagonal)->cage.blocks == cage::BlockWay::Faces);
    // Blocks that are known not to be there are not looked for again; recognised bodies stay.
    far.faces_refused = true;
    CHECK(convert::choose_next({far}, made(), diagonal)->cage.blocks == cage::BlockWay::None);
    CHECK(convert::choose_next({far}, made(), diagonal)->cage.method == cage::Method::Auto);
    convert::ConvertOptions blocks_only = made();
    blocks_only.method = cage::Method::Aligned;
    CHECK_FALSE(convert::choose_next({far}, blocks_only, diagonal).has_value());
}

TEST_CASE("remeshed cages get shorter edges where they miss, three times a place", "[convert]") {
    const AttemptPlan remesh = *convert::choose_next({}, made(), diagonal);
    CHECK(remesh.preserve_parametrisation);
    std::vector<Attempt> attempts{attempt(remesh, CageKind::Remeshed, 5.0)};
    for (std::size_t halvings = 1; halvings <= 3; ++halvings) {
        attempts.push_back(next_of(attempts, CageKind::Remeshed, 2.0));
        const auto& finer_at = attempts.back().plan.cage.finer_at;
        REQUIRE(finer_at.size() == halvings);
        CHECK(finer_at.back().balls.at(0).centre == geom::Vec3(1, 2, 3));
        CHECK_FALSE(attempts.back().plan.same_cage(attempts[halvings - 1].plan));
    }
    CHECK_FALSE(convert::choose_next(attempts, made(), diagonal).has_value());
    // Elsewhere edges are as long as they were.
    for (measure::Condition& condition : attempts.back().verdict.conditions)
        if (!condition.met) condition.at = geom::Vec3(-50, 0, 0);
    const auto elsewhere = convert::choose_next(attempts, made(), diagonal);
    REQUIRE(elsewhere.has_value());
    CHECK(elsewhere->cage.finer_at.size() == 4);
    // All faces that the fit misses get shorter edges at once.
    Attempt many = attempt(remesh, CageKind::Remeshed, 2.0);
    many.misses = {{1, 2, 3}, {200, 0, 0}, {-300, 0, 0}, {205, 0, 0}};
    const auto at_once = convert::choose_next({many}, made(), diagonal);
    REQUIRE(at_once.has_value());
    CHECK(at_once->cage.finer_at.front().balls.size() == 3);
    // So do those that fold.
    many.folds.worst = measure::Fold{{0, 400, 0}, 0, 2.0};
    many.folds.by_face = {{{0, 0, 300}, 4, 1.0}, {{0, 400, 0}, 7, 2.0}};
    const auto with_folds = convert::choose_next({many}, made(), diagonal);
    REQUIRE(with_folds.has_value());
    CHECK(with_folds->cage.finer_at.front().balls.size() == 5);
}

TEST_CASE("the best attempt is the first of equal ones", "[convert]") {
    const Attempt far = attempt({}, CageKind::Sections, 3.0),
                  near = attempt({}, CageKind::Sections, 2.0);
    CHECK(convert::choose_best({far, near, near}) == 1);
    CHECK_FALSE(convert::choose_best({}).has_value());
}
