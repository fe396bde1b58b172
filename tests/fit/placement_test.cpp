#include "fit/loop/placement.h"

#include "support/cages.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace patchwright;

namespace {

/// A strip of quads with vertices at these places along x.
mesh::Cage strip(const std::vector<double>& x) {
    mesh::Cage cage = test::grid(int(x.size()) - 1, 1);
    for (std::size_t i = 0; i < x.size(); ++i)
        for (const int j : {0, 1}) cage.points(Eigen::Index(2 * i) + j, 0) = x[i];
    return cage;
}

fit::Moves ends(const mesh::Cage& cage, const geom::Vec3& first, const geom::Vec3& last) {
    const int n = cage.topology->vertex_count();
    using mesh::VertexId;
    return {{VertexId{0}, first},
            {VertexId{1}, first},
            {VertexId{n - 2}, last},
            {VertexId{n - 1}, last}};
}

}  // namespace

TEST_CASE("moves are carried along linearly in length, however uneven rows are", "[fit][oracle]") {
    const std::vector<double> x{0.0, 0.01, 0.03, 1.0, 5.0, 5.5, 8.0};
    const mesh::Cage cage = strip(x);
    const auto moves =
        fit::carried_along(*cage.topology, cage.points, ends(cage, {0, 0, 1}, {0, 0, 0}), 0.0);
    REQUIRE(moves);
    for (std::size_t i = 0; i < x.size(); ++i)
        CHECK((*moves)(Eigen::Index(2 * i), 2) == Approx(1.0 - x[i] / 8.0).margin(1e-12));
}

TEST_CASE("moves that fade do so by the same factor from row to row", "[fit][oracle]") {
    std::vector<double> x;
    for (int i = 0; i <= 100; ++i) x.push_back(i);
    const mesh::Cage cage = strip(x);
    const double fading = 0.1;
    const auto moves =
        fit::carried_along(*cage.topology, cage.points, ends(cage, {0, 0, 1}, {0, 0, 0}), fading);
    REQUIRE(moves);
    // Two edges along the strip and one across, which joins equal moves: d + 1 / d is 2 + 3 fading.
    const double half = 1.0 + 1.5 * fading;
    const double factor = half - std::sqrt(half * half - 1.0);
    for (int i = 0; i < 20; ++i)
        CHECK((*moves)(2 * i, 2) == Approx(std::pow(factor, i)).margin(1e-12));
}
