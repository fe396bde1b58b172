#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/patch/extract.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <map>

using namespace patchwright;
using geom::Vec3;
using mesh::FaceId;

namespace {

std::vector<mesh::Cage> cages() {
    std::vector<mesh::Cage> all{test::cube(2.0), test::torus(8, 6, 3, 1), test::grid(3, 2)};
    for (const int n : {3, 5, 6, 8, 12}) all.push_back(test::fan(n));
    for (unsigned seed = 0; seed < 24; ++seed) {
        all.push_back(
            test::random_cage(seed, {.open = seed % 2 == 1,
                                     .crease_share = 0.1 * (seed % 4),
                                     .semi_sharp = seed % 5 == 0,
                                     .rule = seed % 4 < 2 ? mesh::BoundaryRule::EdgeOnly
                                                          : mesh::BoundaryRule::EdgeAndCorner}));
    }
    return all;
}

/// Parameter of side i (v = 0, u = 1, v = 1, u = 0) at s, counter-clockwise.
Eigen::Vector2d on_side(std::size_t side, double s) {
    switch (side) {
        case 0: return {s, 0};
        case 1: return {1, s};
        case 2: return {1 - s, 1};
        default: return {0, 1 - s};
    }
}

}  // namespace

TEST_CASE("patches are the limit surface away from caps", "[patch][oracle]") {
    for (const mesh::Cage& cage : cages()) {
        const auto extraction = patch::extract(cage, {.cap_depth = 4});
        const subd::LimitEvaluator evaluator(extraction.cage.topology);
        double worst = 0.0;
        for (const FaceId f : extraction.cage.topology->faces()) {
            const auto& surface = extraction.patches.patches[f.index()].surface;
            // The cap is a square of 1/16 at one corner; its outer border still belongs to the
            // surface.
            for (const auto& [u, v] : {std::pair{0.5, 0.5},
                                       {0.0625, 0.0},
                                       {0.0625, 0.0625},
                                       {0.9375, 0.02},
                                       {1.0, 0.9375},
                                       {0.03, 0.9375},
                                       {0.2, 0.1},
                                       {0.0, 0.4},
                                       {0.97, 0.9},
                                       {0.0, 0.0},
                                       {1.0, 0.0},
                                       {1.0, 1.0},
                                       {0.0, 1.0}}) {
                const Vec3 expected = evaluator.position(extraction.cage.points, {f, u, v});
                worst = std::max(worst, (surface.at(u, v).position - expected).norm());
            }
        }
        CHECK(worst < 1e-13 * 20);
    }
}

TEST_CASE("caps approach the limit surface with their depth", "[patch][oracle]") {
    const mesh::Cage cage = subd::refine(test::cube(2.0), 1);
    const subd::LimitEvaluator evaluator(cage.topology);
    const auto worst = [&](int depth) {
        const auto extraction = patch::extract(cage, {.cap_depth = depth});
        REQUIRE(extraction.refinements == 0);
        double distance = 0.0;
        for (const FaceId f : cage.topology->faces()) {
            const auto& surface = extraction.patches.patches[f.index()].surface;
            for (int corner = 0; corner < 4; ++corner) {
                for (const double t : {0.3, 0.6, 0.9}) {
                    const double s = std::ldexp(t, -depth);
                    const double u = corner == 1 || corner == 2 ? 1 - s : s;
                    const double v = corner >= 2 ? 1 - s : s;
                    distance = std::max(distance, (surface.at(u, v).position -
                                                   evaluator.position(cage.points, {f, u, v}))
                                                      .norm());
                }
            }
        }
        return distance;
    };
    // Valence 3 has the subdominant eigenvalue 0.41: every level shrinks the error at least so
    // much.
    CHECK(worst(3) < 1e-3);
    CHECK(worst(6) < 0.42 * 0.42 * 0.42 * worst(3));
}

TEST_CASE("neighbouring patches share edges, curves and vertices", "[patch]") {
    for (const mesh::Cage& cage : cages()) {
        const auto extraction = patch::extract(cage);
        const patch::PatchSet& set = extraction.patches;
        std::map<int, int> forward, backward;
        double worst = 0.0;
        for (const patch::Patch& patch : set.patches) {
            for (std::size_t side = 0; side < 4; ++side) {
                REQUIRE(patch.sides[side].size() == 1);
                const auto [e, reversed] = patch.sides[side][0];
                ++(reversed ? backward : forward)[e];
                const patch::PatchEdge& edge = set.edges[std::size_t(e)];
                for (const double s : {0.0, 0.001, 0.03, 0.4, 0.99, 1.0}) {
                    const Eigen::Vector2d uv = on_side(side, s);
                    const Vec3 p = patch.surface.at(uv.x(), uv.y()).position;
                    worst = std::max(worst, (p - edge.curve.at(reversed ? 1 - s : s)).norm());
                }
                const int start = reversed ? edge.end : edge.start;
                const Eigen::Vector2d uv = on_side(side, 0.0);
                worst = std::max(worst, (set.vertices.row(start).transpose() -
                                         patch.surface.at(uv.x(), uv.y()).position)
                                            .norm());
            }
        }
        CHECK(worst < 1e-14 * 100);
        for (std::size_t e = 0; e < set.edges.size(); ++e) {
            CHECK(forward[int(e)] == 1);
            CHECK(backward[int(e)] <= 1);
        }
    }
}

TEST_CASE("cages that are not ready are refined as often as needed", "[patch]") {
    CHECK(patch::extract(test::cube(1.0)).refinements == 1);  // four extraordinary corners a face
    CHECK(patch::extract(test::torus(8, 6, 3, 1)).refinements == 0);
    mesh::TopologyInput tags;
    tags.creases.push_back({0, 1, 2.5});
    CHECK(patch::extract(test::cube(1.0, tags)).refinements == 3);
    const auto creased = patch::extract(test::cube(1.0));
    CHECK(patch::crease_midpoints(creased.patches).rows() == 0);
    CHECK(creased.caps == 24);
}

TEST_CASE("a cap depth out of range is refused", "[patch][errors]") {
    CHECK_THROWS_AS(patch::extract(test::cube(1.0), {.cap_depth = 0}), base::InvalidArgument);
    CHECK_THROWS_AS(patch::extract(test::cube(1.0), {.cap_depth = 21}), base::InvalidArgument);
}
