#include "support/cages.h"
#include "support/joints.h"

#include <patchwright/base/error.h>
#include <patchwright/patch/extract.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <map>
#include <set>

using namespace patchwright;
using geom::Vec3;
using mesh::FaceId;
using patch::Covering;
using patch::Join;

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
    // Lines end at creases by the other rule where extraordinary vertices are not too near.
    const auto with_runouts = [&](const mesh::Cage& cage) {
        all.push_back({std::make_shared<const mesh::Topology>(
                           cage.topology->with(mesh::CreaseRule::ParabolicRunout)),
                       cage.points});
        CHECK(all.back().topology->has_runouts());
    };
    mesh::TopologyInput corners;
    corners.boundary_rule = mesh::BoundaryRule::EdgeAndCorner;
    with_runouts(test::grid(5, 4, corners));
    for (unsigned seed = 1; seed < 8; seed += 2)
        with_runouts(subd::refine(
            test::random_cage(seed, {.open = true, .crease_share = 0.1 * (seed % 4)}), 2));
    return all;
}

/// A face's parameters after `turns` quarter turns of the face.
Eigen::Vector2d turned(Eigen::Vector2d uv, int turns) {
    for (int k = 0; k < turns; ++k) uv = {1.0 - uv.y(), uv.x()};
    return uv;
}

}  // namespace

TEST_CASE("patches are the limit surface away from caps", "[patch][oracle]") {
    const auto join = GENERATE(Join::G1, Join::Refined);
    for (const mesh::Cage& cage : cages()) {
        const auto extraction =
            patch::extract(cage, {.join = join, .covering = Covering::Faces, .cap_depth = 4});
        const subd::LimitEvaluator evaluator(extraction.cage.topology);
        double worst = 0.0;
        for (const FaceId f : extraction.cage.topology->faces()) {
            const auto& surface = extraction.patches.patches[f.index()].surface;
            // A cap is a square of at most 1/8 at a corner; its outer border still belongs to the
            // surface.
            for (const auto& [u, v] : {std::pair{0.5, 0.5},
                                       {0.125, 0.0},
                                       {0.125, 0.125},
                                       {0.875, 0.02},
                                       {1.0, 0.875},
                                       {0.06, 0.875},
                                       {0.2, 0.1},
                                       {0.0, 0.4},
                                       {0.97, 0.8},
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

TEST_CASE("charts cover every face once, as the limit surface", "[patch][oracle]") {
    for (const mesh::Cage& cage : cages()) {
        const auto extraction = patch::extract(cage, {.cap_depth = 3});
        const subd::LimitEvaluator evaluator(extraction.cage.topology);
        std::vector<Vec3> centres;
        for (const FaceId f : extraction.cage.topology->faces()) {
            centres.push_back(evaluator.position(extraction.cage.points, {f, 0.5, 0.5}));
        }
        std::set<std::size_t> covered;
        double worst = 0.0;
        for (const patch::Patch& patch : extraction.patches.patches) {
            for (int i = 0; i < int(patch.surface.knots_u.back()); ++i) {
                for (int j = 0; j < int(patch.surface.knots_v.back()); ++j) {
                    const Vec3 centre = patch.surface.at(i + 0.5, j + 0.5).position;
                    const auto nearest = std::min_element(
                        centres.begin(), centres.end(), [&](const Vec3& a, const Vec3& b) {
                            return (a - centre).norm() < (b - centre).norm();
                        });
                    const auto f = FaceId{int(nearest - centres.begin())};
                    covered.insert(f.index());
                    const Vec3 point = patch.surface.at(i + 0.6, j + 0.3).position;
                    double off = std::numeric_limits<double>::infinity();
                    for (int turns = 0; turns < 4; ++turns) {
                        const Eigen::Vector2d uv = turned({0.6, 0.3}, turns);
                        const Vec3 p =
                            evaluator.position(extraction.cage.points, {f, uv.x(), uv.y()});
                        off = std::min(off, (p - point).norm());
                    }
                    worst = std::max(worst, std::max(off, (*nearest - centre).norm()));
                }
            }
        }
        CHECK(covered.size() == centres.size());
        CHECK(worst < 1e-13 * 20);
    }
}

TEST_CASE("neighbouring patches share edges, curves and vertices", "[patch]") {
    const auto covering = GENERATE(Covering::Charts, Covering::Faces);
    for (const mesh::Cage& cage : cages()) {
        const patch::PatchSet set = patch::extract(cage, {.covering = covering}).patches;
        std::vector<int> forward(set.edges.size()), backward(set.edges.size());
        double worst = 0.0;
        for (const patch::Patch& patch : set.patches) {
            std::set<int> own;
            for (std::size_t side = 0; side < 4; ++side) {
                REQUIRE(!patch.sides[side].empty());
                double s = 0.0;
                for (const auto& [e, reversed] : patch.sides[side]) {
                    ++(reversed ? backward : forward)[std::size_t(e)];
                    CHECK(own.insert(e).second);
                    const patch::PatchEdge& edge = set.edges[std::size_t(e)];
                    CHECK(edge.start != edge.end);
                    const int start = reversed ? edge.end : edge.start;
                    const Eigen::Vector2d uv = test::on_side(patch.surface, side, s);
                    worst = std::max(worst, (set.vertices.row(start).transpose() -
                                             patch.surface.at(uv.x(), uv.y()).position)
                                                .norm());
                    s += edge.curve.end();
                }
                const auto& knots = side % 2 == 0 ? patch.surface.knots_u : patch.surface.knots_v;
                CHECK(s == knots.back());
            }
        }
        for (const test::Joint& joint : test::measure_joints(set)) {
            worst = std::max(worst, joint.gap);
        }
        CHECK(worst < 1e-13);
        for (std::size_t e = 0; e < set.edges.size(); ++e) {
            CHECK(forward[e] == 1);
            CHECK(backward[e] <= 1);
            CHECK_FALSE((set.edges[e].crease && backward[e] == 0));
        }
    }
}

TEST_CASE("inner knots are double at most", "[patch]") {
    for (const mesh::Cage& cage : cages()) {
        for (const patch::Patch& patch : patch::extract(cage).patches.patches) {
            for (const auto* knots : {&patch.surface.knots_u, &patch.surface.knots_v}) {
                for (std::size_t k = 4; k + 6 < knots->size(); ++k) {
                    CHECK((*knots)[k] < (*knots)[k + 2]);
                }
            }
        }
    }
}

TEST_CASE("only cages with other polygons than quads are refined", "[patch]") {
    CHECK(patch::extract(test::cube(1.0)).refinements == 0);
    mesh::TopologyInput tags;
    tags.creases.push_back({0, 1, 2.5});
    const auto semi_sharp = patch::extract(test::cube(1.0, tags));
    CHECK(semi_sharp.refinements == 0);
    CHECK(patch::crease_midpoints(semi_sharp.patches).rows() == 0);
    const mesh::Cage tetrahedron =
        test::make_cage({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
                        {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
    const auto refined = patch::extract(tetrahedron);
    CHECK(refined.refinements == 1);
    CHECK(refined.patches.patches.size() == 12);
}

TEST_CASE("patches are named by groups and number", "[patch]") {
    mesh::TopologyInput tags;
    tags.face_group = {0, 0, 1, 1, 1, 1};
    tags.group_names = {"ends", "sides"};
    const mesh::Cage cage = test::cube(1.0, tags);
    const auto names = [&](const patch::ExtractOptions& options) {
        std::vector<std::string> all;
        for (const auto& p : patch::extract(cage, options).patches.patches) all.push_back(p.name);
        return all;
    };
    CHECK(names({})[0] == "ends/chart 0");
    CHECK(names({.covering = Covering::Faces})[5] == "sides/face 5");
    CHECK(patch::extract(test::cube(1.0)).patches.patches[2].name == "chart 2");
}

TEST_CASE("two runs give the same patches", "[patch]") {
    const mesh::Cage cage = test::random_cage(3, {.open = true});
    const auto a = patch::extract(cage).patches, b = patch::extract(cage).patches;
    REQUIRE(a.patches.size() == b.patches.size());
    for (std::size_t k = 0; k < a.patches.size(); ++k) {
        CHECK(a.patches[k].surface.points == b.patches[k].surface.points);
        CHECK(a.patches[k].surface.knots_u == b.patches[k].surface.knots_u);
    }
}

TEST_CASE("options out of range are refused", "[patch][errors]") {
    const mesh::Cage cage = test::cube(1.0);
    CHECK_THROWS_AS(patch::extract(cage, {.cap_depth = 0}), base::InvalidArgument);
    CHECK_THROWS_AS(patch::extract(cage, {.cap_depth = 21}), base::InvalidArgument);
    CHECK_THROWS_AS(patch::extract(cage, {.tolerance_mm = -1.0}), base::InvalidArgument);
    CHECK_THROWS_AS(patch::extract(cage, {.tolerance_mm = 0.0}), base::InvalidArgument);
}
