#include "support/cages.h"
#include "support/joints.h"

#include <patchwright/patch/extract.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

using namespace patchwright;
using geom::Vec3;
using mesh::VertexId;
using patch::Join;

namespace {

constexpr double degree = M_PI / 180.0;
/// The project's bound is 1e-5 degrees; rounding near deep corners leaves 3e-7.
constexpr double rounding = 1e-6 * degree;

/// A fan of quads around a boundary vertex: `faces` of them over `opening` radians.
mesh::Cage open_fan(int faces, double opening, mesh::TopologyInput tags = {}) {
    std::vector<Vec3> points{Vec3(0, 0, 0.3)};
    std::vector<std::vector<int>> quads;
    for (int k = 0; k <= 2 * faces; ++k) {
        const double a = opening * k / (2 * faces);
        const double r = k % 2 == 0 ? 1.0 : 1.4;
        points.emplace_back(r * std::cos(a), r * std::sin(a), 0.1 * std::cos(2 * a));
    }
    for (int k = 0; k < faces; ++k) quads.push_back({0, 1 + 2 * k, 2 + 2 * k, 3 + 2 * k});
    return test::make_cage(points, quads, std::move(tags));
}

/// A closed fan (test::fan) with infinitely sharp spokes.
mesh::Cage creased_fan(int faces, const std::vector<int>& sharp_spokes) {
    const mesh::Cage smooth = test::fan(faces);
    mesh::TopologyInput tags;
    for (const int k : sharp_spokes) {
        tags.creases.push_back({0, 1 + 2 * k, mesh::infinite_sharpness});
    }
    std::vector<Vec3> points;
    for (Eigen::Index i = 0; i < smooth.points.rows(); ++i)
        points.emplace_back(smooth.points.row(i).transpose());
    std::vector<std::vector<int>> quads;
    for (int k = 0; k < faces; ++k) {
        quads.push_back({0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % (2 * faces)});
    }
    return test::make_cage(points, quads, std::move(tags));
}

double largest_kink(const patch::PatchSet& set) {
    double kink = 0.0;
    for (const test::Joint& joint : test::measure_joints(set)) {
        if (!joint.crease) kink = std::max(kink, joint.kink);
    }
    return kink;
}

/// Least cosine between the normals of patches of one face each, over parameters up to `size`, and
/// their mean.
double least_turn(const patch::Extraction& extraction, double size) {
    std::vector<Vec3> normals;
    Vec3 sum = Vec3::Zero();
    for (const auto& patch : extraction.patches.patches) {
        for (double u = 0.05; u < 1.0; u += 0.1) {
            for (double v = 0.05; v < 1.0; v += 0.1) {
                const auto at = patch.surface.at(u * size, v * size);
                normals.push_back(at.du.cross(at.dv).normalized());
                sum += normals.back();
            }
        }
    }
    double least = 1.0;
    for (const Vec3& normal : normals) least = std::min(least, normal.dot(sum.normalized()));
    return least;
}

const patch::CapReport& cap_at(const patch::Extraction& extraction, int vertex) {
    for (const patch::CapReport& cap : extraction.caps) {
        if (cap.vertex == VertexId{vertex}) return cap;
    }
    FAIL("no cap at vertex " << vertex);
    return extraction.caps.front();
}

}  // namespace

TEST_CASE("tangent planes agree at smooth vertices of any valence", "[patch][oracle]") {
    for (const int n : {3, 5, 6, 7, 8, 9, 10, 11, 12, 20}) {
        CAPTURE(n);
        const auto extraction = patch::extract(test::fan(n));
        CHECK(cap_at(extraction, 0).smooth);
        CHECK(cap_at(extraction, 0).faces == n);
        CHECK(largest_kink(extraction.patches) < rounding);
    }
}

TEST_CASE("caps of narrow faces take no more knots than those of wide ones", "[patch][oracle]") {
    const auto depth = [](int faces) {
        std::vector<Vec3> points{Vec3(0, 0, 0)};
        std::vector<std::vector<int>> quads;
        for (int k = 0; k < 2 * faces; ++k) {
            const double a = M_PI * k / faces, r = k % 2 == 0 ? 1.0 : 1.2;
            points.emplace_back(r * std::cos(a), r * std::sin(a), -0.5 * r);
        }
        for (int k = 0; k < faces; ++k)
            quads.push_back({0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % (2 * faces)});
        const auto extraction =
            patch::extract(test::make_cage(points, quads), {.tolerance_mm = 3e-4});
        CHECK(cap_at(extraction, 0).smooth);
        CHECK(cap_at(extraction, 0).distance_mm <= 3e-4);
        return cap_at(extraction, 0).depth;
    };
    const int wide = depth(32);
    for (const int faces : {128, 256, 512}) {
        CAPTURE(faces);
        CHECK(depth(faces) <= wide + 1);
    }
}

TEST_CASE("the fan in the middle of a 1,000-gon is filled at depth 4", "[patch]") {
    // The top of a prism. Going on from fits whose parameters had turned over took two depths more.
    constexpr int sides = 1000;
    std::vector<Vec3> points;
    std::vector<std::vector<int>> faces{{}};
    for (int k = 0; k < sides; ++k) {
        const double a = 2 * M_PI * k / sides;
        const int next = (k + 1) % sides;
        points.emplace_back(100 * std::cos(a), 100 * std::sin(a), 0);
        faces[0].push_back(sides + k);
        faces.push_back({k, next, sides + next, sides + k});
    }
    for (int k = 0; k < sides; ++k) points.push_back(points[std::size_t(k)] + Vec3(0, 0, 100));
    const auto extraction = patch::extract(test::make_cage(points, faces), {.tolerance_mm = 0.03});
    const auto middle = std::find_if(extraction.caps.begin(), extraction.caps.end(),
                                     [](const auto& cap) { return cap.faces == sides; });
    REQUIRE(middle != extraction.caps.end());
    CHECK(middle->smooth);
    CHECK(middle->distance_mm <= 0.03);
    CHECK(middle->depth <= 4);
}

TEST_CASE("tangent planes agree at boundaries", "[patch][oracle]") {
    for (int faces = 2; faces <= 6; ++faces) {
        CAPTURE(faces);
        const auto extraction = patch::extract(open_fan(faces, M_PI));
        CHECK(largest_kink(extraction.patches) < rounding);
        if (faces == 2) continue;  // the vertex is inside an edge
        // The boundary curve is that of the limit surface, whatever the cap is.
        const subd::LimitEvaluator evaluator(extraction.cage.topology);
        for (const double t : {1e-3, 1e-2, 0.1}) {
            const Vec3 limit = evaluator.position(extraction.cage.points, {mesh::FaceId{0}, t, 0});
            double off = 1.0;
            for (const auto& edge : extraction.patches.edges) {
                for (const double s : {t, edge.curve.end() - t})
                    off = std::min(off, (edge.curve.at(s) - limit).norm());
            }
            CHECK(off < 1e-14);
        }
    }
}

TEST_CASE("tangent planes agree at corners, convex and reflex", "[patch][oracle]") {
    mesh::TopologyInput tags;
    tags.corners.push_back({0, mesh::infinite_sharpness});
    for (int faces = 2; faces <= 6; ++faces) {
        for (const double opening : {0.4 * M_PI, 0.8 * M_PI, 1.5 * M_PI}) {
            CAPTURE(faces, opening);
            const auto extraction = patch::extract(open_fan(faces, opening, tags));
            CHECK(cap_at(extraction, 0).smooth);
            CHECK(largest_kink(extraction.patches) < rounding);
        }
    }
}

TEST_CASE("corner caps do not fold where the surface stands upright on their edges",
          "[patch][oracle]") {
    // Sharp edges 156 degrees apart, with the smooth one between them nearly at right angles to
    // both: on which side of their plane it leans says little about which side the surface takes.
    mesh::TopologyInput tags;
    tags.corners.push_back({0, mesh::infinite_sharpness});
    const double opening = 156.0 * degree;
    const Vec3 last(std::cos(opening), std::sin(opening), 0);
    for (const double lean : {-0.1, -0.03, 0.03, 0.1}) {
        CAPTURE(lean);
        const Vec3 middle(0, lean, 1);
        const mesh::Cage cage = test::make_cage(
            {Vec3::Zero(), Vec3(1, 0, 0), middle + Vec3(1, 0, 0), middle, middle + last, last},
            {{0, 1, 2, 3}, {0, 3, 4, 5}}, tags);
        const auto extraction = patch::extract(cage, {.covering = patch::Covering::Faces});
        CHECK(cap_at(extraction, 0).smooth);
        CHECK(largest_kink(extraction.patches) < rounding);
        CHECK(least_turn(extraction, std::ldexp(1.0, 1 - cap_at(extraction, 0).depth)) > 0.0);
    }
}

TEST_CASE("caps whose parameters turn over get deeper", "[patch][oracle]") {
    // Four quads over 347 degrees around the root of a winglet, as fitted. The limit surface's
    // parameters do not turn over.
    mesh::TopologyInput tags;
    tags.corners.push_back({0, mesh::infinite_sharpness});
    const mesh::Cage cage = test::make_cage(
        {Vec3(0, 0, 0), Vec3(-4.9, 0.64, 0.59), Vec3(-4.5, 3.61, 0.18), Vec3(0.42, 3.34, -0.52),
         Vec3(0.96, 4.75, -0.72), Vec3(2.35, 0.62, -0.51), Vec3(1.63, -1.91, 0.1),
         Vec3(0.06, -3.2, 0.55), Vec3(-5.24, -3.25, 1.24), Vec3(-4.17, -0.47, 0.66)},
        {{0, 1, 2, 3}, {0, 3, 4, 5}, {0, 5, 6, 7}, {0, 7, 8, 9}}, tags);
    for (const double tolerance : {0.5, 0.1, 0.02, 1e-3}) {
        CAPTURE(tolerance);
        const auto extraction =
            patch::extract(cage, {.covering = patch::Covering::Faces, .tolerance_mm = tolerance});
        CHECK(least_turn(extraction, 1.0) > 0.0);
    }
}

TEST_CASE("tangent planes agree beside creases, at darts and at corners of creases",
          "[patch][oracle]") {
    const std::vector<std::pair<int, std::vector<int>>> cases{
        {4, {0}},    {3, {0}},       {7, {2}},       {5, {0, 2}},    {6, {0, 3}},
        {6, {0, 1}}, {8, {0, 2, 5}}, {9, {0, 3, 6}}, {4, {0, 1, 2}}, {12, {0, 5}}};
    for (const auto& [n, spokes] : cases) {
        CAPTURE(n, spokes);
        const auto extraction = patch::extract(creased_fan(n, spokes));
        int creases = 0;
        for (const auto& edge : extraction.patches.edges) creases += edge.crease ? 1 : 0;
        CHECK(creases == int(spokes.size()));
        for (const patch::CapReport& cap : extraction.caps) CHECK(cap.smooth);
        CHECK(largest_kink(extraction.patches) < rounding);
    }
}

TEST_CASE("random cages are smooth wherever a cap says so", "[patch][oracle]") {
    int unsmooth = 0, caps = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
        CAPTURE(seed);
        const mesh::Cage cage =
            test::random_cage(seed, {.open = seed % 2 == 1,
                                     .crease_share = 0.1 * (seed % 4),
                                     .semi_sharp = seed % 5 == 0,
                                     .rule = seed % 4 < 2 ? mesh::BoundaryRule::EdgeOnly
                                                          : mesh::BoundaryRule::EdgeAndCorner});
        const auto extraction = patch::extract(cage, {.covering = patch::Covering::Faces});
        const auto& t = *extraction.cage.topology;
        std::vector<char> excused(std::size_t(t.vertex_count()), 0);
        for (const patch::CapReport& cap : extraction.caps) {
            ++caps;
            if (cap.smooth) continue;
            ++unsmooth;
            excused[cap.vertex.index()] = 1;
        }
        for (const test::Joint& joint : test::measure_joints(extraction.patches)) {
            // With a patch a face, edges of the set lie on those of the mesh, vertices likewise.
            const auto& edge = extraction.patches.edges[std::size_t(joint.edge)];
            bool exempt = joint.crease;
            for (const auto v : t.vertices()) {
                if (excused[v.index()] == 0) continue;
                const Vec3 limit = subd::limit_position(extraction.cage, v);
                for (const int end : {edge.start, edge.end}) {
                    exempt =
                        exempt ||
                        (extraction.patches.vertices.row(end).transpose() - limit).norm() < 1e-9;
                }
            }
            if (!exempt) CHECK(joint.kink < rounding);
        }
    }
    // Sharp vertices without sharp edges, and corners whose sharp edges are nearly parallel.
    CHECK(unsmooth < caps / 10);
}

TEST_CASE("caps keep the tolerance, and take no more knots than it needs", "[patch][oracle]") {
    for (const int n : {3, 5, 6, 8}) {
        const mesh::Cage cage = subd::refine(test::fan(n), 1);
        const subd::LimitEvaluator evaluator(cage.topology);
        int last_depth = 0;
        for (const double tolerance : {1e-3, 1e-4, 1e-5}) {
            CAPTURE(n, tolerance);
            const auto extraction = patch::extract(
                cage, {.covering = patch::Covering::Faces, .tolerance_mm = tolerance});
            const patch::CapReport& cap = cap_at(extraction, 0);
            CHECK(cap.distance_mm <= tolerance);
            CHECK(cap.depth >= last_depth);
            last_depth = cap.depth;
            // Points of the limit surface against a dense net of points of the first patch: the
            // distance along its normals, which is what is left of it for near points.
            const auto& surface = extraction.patches.patches[0].surface;
            const double size = std::ldexp(2.0, -cap.depth);
            double worst = 0.0;
            for (double u = 0.015; u < 1.0; u += 0.03) {
                for (double v = 0.015; v < 1.0; v += 0.03) {
                    const auto at = surface.at(u * size, v * size);
                    Eigen::Vector2d uv(u * size, v * size);
                    Vec3 off;
                    for (int step = 0; step < 8; ++step) {
                        const auto limit =
                            evaluator.evaluate(cage.points, {mesh::FaceId{0}, uv.x(), uv.y()});
                        off = at.position - limit.position;
                        Eigen::Matrix<double, 3, 2> tangents;
                        tangents << limit.du, limit.dv;
                        uv += (tangents.transpose() * tangents)
                                  .ldlt()
                                  .solve(tangents.transpose() * off);
                        uv = uv.cwiseMax(1e-9).cwiseMin(1.0);
                    }
                    worst = std::max(worst, off.norm());
                }
            }
            // 25 samples a face of the fan miss the very largest distance.
            CHECK(worst < 1.5 * tolerance);
        }
        CHECK(last_depth <= 10);
    }
}

TEST_CASE("the refined continuity leaves a kink that depth makes small", "[patch][oracle]") {
    for (const int n : {3, 5, 6, 8}) {
        CAPTURE(n);
        const auto kink = [&](int depth) {
            return largest_kink(
                patch::extract(test::fan(n), {.join = Join::Refined, .cap_depth = depth}).patches);
        };
        CHECK(kink(8) > 1e-6 * degree);
        CHECK(kink(12) < 0.5 * kink(8));
        const auto extraction =
            patch::extract(test::fan(n), {.join = Join::Refined, .cap_depth = 8});
        CHECK_FALSE(cap_at(extraction, 0).smooth);
        CHECK(cap_at(extraction, 0).depth == 8);
    }
}

TEST_CASE("a sharp vertex without sharp edges keeps its point", "[patch]") {
    mesh::TopologyInput tags;
    tags.corners.push_back({7, mesh::infinite_sharpness});
    const mesh::Cage cage = test::cube(2.0, tags);
    const auto extraction = patch::extract(cage);
    CHECK_FALSE(cap_at(extraction, 7).smooth);
    CHECK(cap_at(extraction, 0).smooth);
    bool found = false;
    for (Eigen::Index v = 0; v < extraction.patches.vertices.rows(); ++v) {
        found = found ||
                (extraction.patches.vertices.row(v).transpose() - Vec3(1, 1, 1)).norm() < 1e-14;
    }
    CHECK(found);
}
