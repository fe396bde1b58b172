#include "geom/shortest_paths.h"

#include <catch2/catch.hpp>

#include <random>

namespace patchwright::geom {
namespace {

using Edges = std::vector<std::vector<std::pair<int, double>>>;

auto along(const Edges& edges) {
    return [&edges](int node, double length, const auto& reach) {
        for (const auto& [next, step] : edges[std::size_t(node)]) reach(next, length + step);
    };
}

TEST_CASE("shortest paths agree with all pairs by Floyd and Warshall", "[geom][oracle]") {
    constexpr int count = 40;
    std::mt19937 random(7);
    std::uniform_int_distribution<int> node(0, count - 1);
    std::uniform_real_distribution<double> step(0.1, 1.0);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    std::vector<std::vector<double>> all(count, std::vector<double>(count, infinity));
    Edges edges(count);
    for (int i = 0; i < count; ++i) all[std::size_t(i)][std::size_t(i)] = 0.0;
    for (int k = 0; k < 90; ++k) {
        const int a = node(random), b = node(random);
        const double length = step(random);
        edges[std::size_t(a)].emplace_back(b, length);
        double& known = all[std::size_t(a)][std::size_t(b)];
        known = std::min(known, length);
    }
    for (std::size_t k = 0; k < count; ++k)
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t j = 0; j < count; ++j)
                all[i][j] = std::min(all[i][j], all[i][k] + all[k][j]);
    for (int a = 0; a < count; ++a) {
        const ShortestPaths found = shortest_paths(count, {{a, 0.0}}, along(edges));
        for (std::size_t b = 0; b < count; ++b) {
            if (all[std::size_t(a)][b] == infinity) {
                CHECK(found.length[b] == infinity);
                continue;
            }
            CHECK(found.length[b] == Approx(all[std::size_t(a)][b]));
            CHECK(found.path_to(int(b)).front() == a);
        }
    }
}

TEST_CASE("several starts with lengths of their own", "[geom]") {
    const Edges line{{{1, 1.0}}, {{0, 1.0}, {2, 1.0}}, {{1, 1.0}, {3, 1.0}}, {{2, 1.0}}};
    const ShortestPaths found = shortest_paths(4, {{0, 0.0}, {3, 1.5}}, along(line));
    CHECK(found.length == std::vector<double>{0.0, 1.0, 2.0, 1.5});
    CHECK(found.path_to(2) == std::vector<int>{0, 1, 2});
    CHECK(found.path_to(3) == std::vector<int>{3});
}

TEST_CASE("searches one after another do not see each other", "[geom]") {
    const Edges edges{{{1, 1.0}}, {{0, 1.0}, {2, 1.0}}, {{1, 1.0}}, {{4, 2.0}}, {{3, 2.0}}};
    PathSearch search(edges.size());
    for (const int start : {0, 3, 2}) {
        search.run({{start, 0.0}}, along(edges));
        const ShortestPaths alone = shortest_paths(edges.size(), {{start, 0.0}}, along(edges));
        CHECK(search.paths().length == alone.length);
        CHECK(search.paths().from == alone.from);
        std::vector<int> reached = search.reached(), with_path;
        std::sort(reached.begin(), reached.end());
        for (int i = 0; i < int(edges.size()); ++i)
            if (alone.length[std::size_t(i)] < std::numeric_limits<double>::infinity())
                with_path.push_back(i);
        CHECK(reached == with_path);
    }
}

}  // namespace
}  // namespace patchwright::geom
