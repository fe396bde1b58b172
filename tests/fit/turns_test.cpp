// Vertices where feature curves turn sharply.
#include "fit/loop/projector.h"
#include "plate.h"
#include "support/cages.h"

#include <patchwright/fit/fit.h>

#include <catch2/catch.hpp>

#include <set>
#include <stdexcept>

using namespace patchwright;
using test::Plate;

TEST_CASE("extraordinary vertices stay where their curve turns sharply", "[fit][features]") {
    // A border without corners around the rim of a plate: one face at each of the plate's corners,
    // two at all other vertices. What lies inside would pull the former along the rim.
    mesh::Cage cage = test::grid(4, 4);
    cage.points = (cage.points.array() - 2.0) * 0.5;
    cage.points.col(2).setConstant(Plate::thickness);
    for (Eigen::Index v = 0; v < cage.points.rows(); ++v)
        if (std::abs(cage.points(v, 0)) < 1.0) cage.points(v, 0) += 0.3;
    const Plate plate;
    const fit::CurveSampling curves = fit::curve_sites(*cage.topology);
    const auto samples = fit::curve_points(cage, curves, 4);
    const auto match = fit::match_features(cage, curves, samples, 4, plate, 0.5, [] {});
    std::set<int> turns;
    for (const fit::CurveTarget& turn : match.turns) turns.insert(turn.vertex.value);
    CHECK(turns == std::set<int>{0, 4, 20, 24});

    const auto result = fit::fit(cage, plate, {.tolerance_mm = 1e-3, .max_levels = 0});
    std::vector<subd::Site> sites;
    for (const int v : turns)
        sites.push_back(fit::vertex_site(*result.cage.topology, mesh::VertexId{v}));
    geom::Points limit;
    subd::LimitOperator(*result.cage.topology, fit::corner_sets(), sites)
        .apply(result.cage.points, limit);
    std::size_t i = 0;
    for (const int v : turns)
        CHECK((limit.row(Eigen::Index(i++)) - cage.points.row(v)).norm() < 0.02);
}

TEST_CASE("matching ends where its poll throws", "[fit][features]") {
    const mesh::Cage cage = test::grid(4, 4);
    const Plate plate;
    const fit::CurveSampling curves = fit::curve_sites(*cage.topology);
    const auto samples = fit::curve_points(cage, curves, 4);
    int polls = 0;
    fit::match_features(cage, curves, samples, 4, plate, 5.0, [&] { ++polls; });
    REQUIRE(polls > int(curves.chains.size()));
    for (int last = 1; last <= polls; ++last) {
        int now = 0;
        const auto poll = [&] {
            if (++now == last) throw std::runtime_error("stop");
        };
        CHECK_THROWS_AS(fit::match_features(cage, curves, samples, 4, plate, 5.0, poll),
                        std::runtime_error);
        CHECK(now == last);
    }
}
