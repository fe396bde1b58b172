#include "measure/limit_folds.h"
#include "support/analytic_references.h"
#include "support/analytic_wing.h"
#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/fit.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <numeric>

using namespace patchwright;
using geom::Vec3;

TEST_CASE("a cube cage is fitted to a sphere within the tolerance", "[fit][oracle]") {
    const auto result =
        fit::fit(subd::refine(test::cube(2.0), 1), test::Sphere(1.0), {.tolerance_mm = 1e-4});
    REQUIRE(result.within_tolerance);
    CHECK(result.levels.back().max_mm <= 1e-4);
    // The fit's own figures are those of the limit surface.
    const subd::LimitEvaluator evaluator(result.cage.topology);
    for (const mesh::FaceId f : result.cage.topology->faces()) {
        CHECK(std::abs(evaluator.position(result.cage.points, {f, 0.21, 0.83}).norm() - 1.0) <
              1e-4);
    }
}

TEST_CASE("the error on a torus falls with refinement at fourth order", "[fit][oracle]") {
    // Bicubic splines: halving the faces divides the error by 16, a little less this early.
    const auto error = [](int nu, int nv) {
        return fit::fit(test::torus(nu, nv, 3.0, 1.0), test::Torus(3.0, 1.0),
                        {.tolerance_mm = 1e-12, .max_levels = 0})
            .levels.back()
            .rms_mm;
    };
    CHECK(error(12, 8) / error(24, 16) > 12.0);
}

namespace {

/// The limit surface of a cage as a reference: nearest samples, improved by Newton on the face.
class LimitReference final : public geom::ReferenceSurface {
  public:
    explicit LimitReference(mesh::Cage cage) : cage_(std::move(cage)), evaluator_(cage_.topology) {
        for (const mesh::FaceId f : cage_.topology->faces()) {
            for (int i = 0; i < 8; ++i) {
                for (int j = 0; j < 8; ++j) {
                    const subd::Location at{f, (i + 0.5) / 8, (j + 0.5) / 8};
                    samples_.push_back({at, evaluator_.position(cage_.points, at)});
                }
            }
        }
    }
    geom::Box3 bounds() const override { return geom::bounding_box(cage_.points); }
    geom::FootPoint foot_point(const Vec3& q, const std::optional<Vec3>&) const override {
        std::vector<std::pair<double, std::size_t>> nearest(4, {1e300, 0});
        for (std::size_t k = 0; k < samples_.size(); ++k) {
            const double d = (samples_[k].second - q).squaredNorm();
            if (d >= nearest.back().first) continue;
            nearest.back() = {d, k};
            std::sort(nearest.begin(), nearest.end());
        }
        geom::FootPoint best;
        best.distance = 1e300;
        for (const auto& [unused, k] : nearest) {
            subd::Location at = samples_[k].first;
            for (int step = 0; step < 20; ++step) {
                const subd::LimitPoint p = evaluator_.evaluate(cage_.points, at);
                const Vec3 r = p.position - q;
                Eigen::Matrix2d h;
                h << p.du.dot(p.du) + r.dot(p.duu), p.du.dot(p.dv) + r.dot(p.duv),
                    p.du.dot(p.dv) + r.dot(p.duv), p.dv.dot(p.dv) + r.dot(p.dvv);
                const Eigen::Vector2d move =
                    h.inverse() * Eigen::Vector2d(r.dot(p.du), r.dot(p.dv));
                at.u = std::clamp(at.u - move.x(), 0.0, 1.0);
                at.v = std::clamp(at.v - move.y(), 0.0, 1.0);
            }
            const subd::LimitPoint p = evaluator_.evaluate(cage_.points, at, 1);
            const double d = (p.position - q).norm();
            if (d < best.distance) best = {p.position, p.normal, d, at.face.value};
        }
        return best;
    }

  private:
    mesh::Cage cage_;
    subd::LimitEvaluator evaluator_;
    std::vector<std::pair<subd::Location, Vec3>> samples_;
};

}  // namespace

TEST_CASE("a disturbed cage finds the limit surface it comes from", "[fit][oracle]") {
    const mesh::Cage cage = subd::refine(test::cube(2.0), 1);
    mesh::Cage disturbed = cage;
    std::srand(7);
    disturbed.points += 0.03 * geom::Points::Random(cage.points.rows(), 3);
    const auto result =
        fit::fit(disturbed, LimitReference(cage),
                 {.tolerance_mm = 1e-10, .max_levels = 0, .solver = {.max_projections = 200}});
    CHECK(result.levels.back().max_mm < 1e-10);
}

TEST_CASE("creases and corners of a cube go to the edges and corners of a box", "[fit][oracle]") {
    mesh::TopologyInput tags;
    for (const auto& face : test::cube_faces) {
        for (std::size_t i = 0; i < 4; ++i) {
            if (face[i] < face[(i + 1) % 4]) {
                tags.creases.push_back({face[i], face[(i + 1) % 4], mesh::infinite_sharpness});
            }
        }
    }
    mesh::Cage cage = test::cube(1.8, tags);
    cage.points.row(3) += Eigen::RowVector3d(0.05, -0.03, 0.02);
    const auto result = fit::fit(cage, test::Box(), {.tolerance_mm = 1e-9});
    CHECK(result.within_tolerance);
    CHECK(result.levels.size() == 1);
    CHECK((result.cage.points.cwiseAbs().array() - 1.0).abs().maxCoeff() < 1e-9);
}

namespace {

/// The box of edge 2 about the origin, 4 x 4 quads a side; a control point of the side z = 1 lies
/// beyond its neighbours, so that quads fold without leaving the side.
mesh::Cage folded_box() {
    mesh::TopologyInput tags;
    for (const auto& face : test::cube_faces)
        for (std::size_t i = 0; i < 4; ++i)
            if (face[i] < face[(i + 1) % 4])
                tags.creases.push_back({face[i], face[(i + 1) % 4], mesh::infinite_sharpness});
    mesh::Cage cage = subd::refine(test::cube(2.0, tags), 2);
    Eigen::Index middle = 0;
    (cage.points.rowwise() - Eigen::RowVector3d(0, 0, 1)).rowwise().norm().minCoeff(&middle);
    cage.points(middle, 0) += 1.6;
    return cage;
}

}  // namespace

TEST_CASE("folds within a flat side are opened, though nothing is far off", "[fit][oracle]") {
    const mesh::Cage cage = folded_box();
    const test::Box box;
    const auto count = [&](const mesh::Cage& c) {
        const auto folded = measure::folded_samples(c, box, 1e-3);
        return std::accumulate(folded.begin(), folded.end(), 0);
    };
    REQUIRE(count(cage) > 0);
    const auto result = fit::fit(cage, box, {.tolerance_mm = 1e-3});
    CHECK(result.within_tolerance);
    CHECK(result.levels[std::size_t(result.best_level)].folded == 0);
    CHECK(count(result.cage) == 0);
}

TEST_CASE("an open cage's boundary goes to the free edge", "[fit][oracle]") {
    mesh::Cage cage = test::grid(4, 4);
    cage.points = (cage.points.array() - 2.0) * 0.35;
    cage.points.col(2).setConstant(0.2);
    const auto result = fit::fit(cage, test::Disc(), {.tolerance_mm = 1e-3});
    REQUIRE(result.within_tolerance);
    const subd::LimitEvaluator evaluator(result.cage.topology);
    const mesh::Topology& t = *result.cage.topology;
    for (const mesh::VertexId v : t.vertices()) {
        if (t.is_boundary(v))
            CHECK(std::abs(subd::limit_position(result.cage, v).norm() - 1.0) < 1e-3);
    }
}

TEST_CASE("lines that are close in the given cage neither change places nor invert faces",
          "[fit][oracle]") {
    // A rim of uniform cubic pieces is nearest to a circle with even lines: these would overtake.
    constexpr std::array<double, 9> degrees{0, 20, 41, 44, 46, 49, 70, 90, 135};
    std::vector<double> angles;
    for (const double turn : {0.0, 180.0})
        for (const double d : degrees) angles.push_back((turn + d) * M_PI / 180.0);
    const int n = int(angles.size());
    std::vector<Vec3> points;
    for (const double radius : {1.0, 0.75, 0.5})
        for (const double a : angles)
            points.emplace_back(radius * std::cos(a), radius * std::sin(a), 0.02);
    std::vector<std::vector<int>> faces(1);
    for (int k = 0; k < n; ++k) {
        for (int ring = 0; ring < 2; ++ring) {
            const int a = ring * n + k, b = ring * n + (k + 1) % n;
            faces.push_back({a, b, b + n, a + n});
        }
        faces[0].push_back(2 * n + k);
    }
    const auto result = fit::fit(test::make_cage(points, faces), test::Disc(),
                                 {.tolerance_mm = 1e-5, .max_levels = 1});
    const mesh::Cage& cage = result.cage;
    const subd::LimitEvaluator evaluator(cage.topology);
    int folded = 0;
    for (const mesh::FaceId f : cage.topology->faces()) {
        if (cage.topology->size(f) != 4) continue;
        for (int i = 0; i < 8; ++i) {
            for (int j = 0; j < 8; ++j) {
                const auto at =
                    evaluator.evaluate(cage.points, {f, (i + 0.5) / 8, (j + 0.5) / 8}, 1);
                if (!(at.du.cross(at.dv).z() > 0.0)) ++folded;
            }
        }
    }
    CHECK(folded == 0);
    CHECK(result.levels.back().curve_max_mm < 1e-3);
}

TEST_CASE("an open cage that faces the other way is fitted as well as one that does not",
          "[fit][oracle]") {
    // Both sides of a thin wing: the nearest points that face the wrong way are on the other one.
    const auto fitted = [](bool turned) {
        mesh::Cage cage = test::naca_wing_cage(16, 2);
        if (turned) {
            mesh::TopologyInput input;
            input.vertex_count = cage.topology->vertex_count();
            for (const mesh::FaceId f : cage.topology->faces()) {
                input.face_sizes.push_back(4);
                for (const int k : {0, 3, 2, 1}) {
                    input.face_vertices.push_back(
                        cage.topology->vertex(cage.topology->corners(f)[k]).value);
                }
            }
            for (const mesh::EdgeId e : cage.topology->edges()) {
                if (!(cage.topology->tagged_sharpness(e) > 0.0)) continue;
                input.creases.push_back({cage.topology->start(e).value, cage.topology->end(e).value,
                                         mesh::infinite_sharpness});
            }
            cage = mesh::build_cage(input, cage.points).cage;
        }
        return fit::fit(cage, test::NacaWing(), {.tolerance_mm = 1e-4});
    };
    const auto right = fitted(false), away = fitted(true);
    CHECK_FALSE(right.faces_away);
    CHECK(away.faces_away);
    REQUIRE(right.within_tolerance);
    REQUIRE(away.within_tolerance);
    CHECK(away.levels.back().vertices == right.levels.back().vertices);
    CHECK(away.levels.back().rms_mm == Approx(right.levels.back().rms_mm).epsilon(1e-3));
}

TEST_CASE("pinned control points do not move", "[fit]") {
    mesh::TopologyInput tags;
    tags.pins = {5};
    const mesh::Cage cage = test::cube(2.0, tags);
    const auto result = fit::fit(cage, test::Sphere(1.0), {.max_levels = 0});
    CHECK(result.cage.points.row(5) == cage.points.row(5));
    CHECK((result.cage.points.row(6) - cage.points.row(6)).norm() > 0.1);
}

TEST_CASE("missing the tolerance is an answer, not an error", "[fit]") {
    const auto result =
        fit::fit(test::cube(2.0), test::Sphere(1.0), {.tolerance_mm = 1e-9, .max_levels = 1});
    CHECK_FALSE(result.within_tolerance);
    CHECK(result.levels.size() == 2);
    CHECK(result.levels[1].max_mm > 1e-9);
}

TEST_CASE("a fit can be cancelled and checks its options", "[fit][errors]") {
    CHECK_THROWS_AS(fit::fit(test::cube(2.0), test::Sphere(1.0),
                             {.progress = [](std::string_view, double) { return false; }}),
                    base::Cancelled);
    CHECK_THROWS_AS(fit::fit(test::cube(2.0), test::Sphere(1.0), {.tolerance_mm = 0.0}),
                    base::InvalidArgument);
}
