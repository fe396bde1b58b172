#include "support/cages.h"

#include <patchwright/mesh/obj.h>
#include <patchwright/mesh/parts.h>
#include <patchwright/mesh/regular.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/limit_operator.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <Eigen/QR>
#include <random>
#include <sstream>

using namespace patchwright;
using geom::Vec3;
using mesh::CornerId;
using mesh::CreaseRule;
using mesh::FaceId;
using mesh::VertexId;

namespace {

mesh::TopologyInput with_corners(CreaseRule rule) {
    mesh::TopologyInput tags;
    tags.boundary_rule = mesh::BoundaryRule::EdgeAndCorner;
    tags.crease_rule = rule;
    return tags;
}

/// A grid with a crease along its middle line of constant u, all points disturbed.
mesh::Cage creased_sheet(int nu, int nv, CreaseRule rule) {
    mesh::TopologyInput tags = with_corners(rule);
    const int first = nu / 2 * (nv + 1);
    for (int j = 0; j < nv; ++j)
        tags.creases.push_back({first + j, first + j + 1, mesh::infinite_sharpness});
    mesh::Cage cage = test::grid(nu, nv, tags);
    std::mt19937 random(7);
    for (Eigen::Index i = 0; i < cage.points.size(); ++i)
        cage.points.data()[i] += 0.4 * double(random()) / std::mt19937::max();
    return cage;
}

/// An open tube: `around` quads around, `along` from border to border, all points disturbed.
mesh::Cage tube(int around, int along, CreaseRule rule) {
    mesh::TopologyInput tags = with_corners(rule);
    std::vector<Vec3> points;
    std::vector<std::vector<int>> faces;
    std::mt19937 random(3);
    for (int j = 0; j <= along; ++j) {
        for (int i = 0; i < around; ++i) {
            const double a = 2.0 * M_PI * i / around;
            const double r = 1.0 + 0.3 * double(random()) / std::mt19937::max();
            points.emplace_back(r * std::cos(a), r * std::sin(a), j + r);
            const auto at = [&](int k, int l) { return l * around + k % around; };
            if (j < along)
                faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
    return test::make_cage(points, faces, std::move(tags));
}

int count_runouts(const mesh::Topology& t) {
    int count = 0;
    for (const mesh::EdgeId e : t.edges())
        for (const VertexId v : {t.start(e), t.end(e)}) count += t.is_runout(e, v) ? 1 : 0;
    return count;
}

/// Largest error of a least-squares fit to z = exp(x) at equal parameters over [0, 1], in the root
/// of the mean square.
double error_of_fit(int faces, CreaseRule rule) {
    mesh::Cage cage = test::grid(faces, 3, with_corners(rule));
    cage.points.leftCols<1>() /= faces;
    const subd::LimitEvaluator evaluator(cage.topology);
    std::vector<std::int32_t> on_face;
    std::vector<double> uv;
    constexpr int samples = 8;
    for (const FaceId f : cage.topology->faces())
        for (int i = 0; i < samples; ++i)
            for (const double v : {0.25, 0.75}) {
                on_face.push_back(f.value);
                uv.insert(uv.end(), {(i + 0.5) / samples, v});
            }
    const subd::Locations at{on_face, uv, {}};
    const subd::Stencils masks = evaluator.masks(at);
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(masks.rows(), masks.columns);
    for (int row = 0; row < masks.rows(); ++row)
        for (auto k = masks.begin[std::size_t(row)]; k < masks.begin[std::size_t(row) + 1]; ++k)
            m(row, masks.index[std::size_t(k)]) = masks.weight[std::size_t(k)];
    Eigen::VectorXd wanted(masks.rows());
    for (int row = 0; row < masks.rows(); ++row) {
        const int column = on_face[std::size_t(row)] / 3;  // faces of one u follow each other
        wanted[row] = std::exp((column + uv[2 * std::size_t(row)]) / faces);
    }
    const Eigen::VectorXd best = m.colPivHouseholderQr().solve(wanted);
    return (m * best - wanted).norm() / std::sqrt(double(masks.rows()));
}

}  // namespace

TEST_CASE("with runouts the limit surface is any quadratic up to its borders", "[subd][oracle]") {
    constexpr int nu = 6, nv = 5;
    mesh::Cage cage = test::grid(nu, nv, with_corners(CreaseRule::ParabolicRunout));
    // Coefficients of t^2: i^2 - 1/3 inside, the value at ends.
    const auto square = [](int i, int n) { return i * i - (i == 0 || i == n ? 0.0 : 1.0 / 3.0); };
    for (int i = 0; i <= nu; ++i)
        for (int j = 0; j <= nv; ++j)
            cage.points(i * (nv + 1) + j, 2) =
                2.0 * square(i, nu) - 0.3 * i * j - square(j, nv) + i;
    const auto exact = [](double x, double y) { return 2.0 * x * x - 0.3 * x * y - y * y + x; };
    const auto largest_error = [&](const mesh::Topology& topology) {
        const subd::LimitEvaluator evaluator(std::make_shared<const mesh::Topology>(topology));
        double largest = 0.0;
        for (int i = 0; i < nu; ++i) {
            for (int j = 0; j < nv; ++j) {
                for (const double u : {0.0, 0.2, 0.7, 1.0}) {
                    for (const double v : {0.0, 0.4, 1.0}) {
                        const auto p = evaluator.evaluate(cage.points, {FaceId{i * nv + j}, u, v});
                        const double x = i + u, y = j + v;
                        largest = std::max({largest, std::abs(p.position.z() - exact(x, y)),
                                            std::abs(p.position.x() - x), std::abs(p.duu.z() - 4.0),
                                            std::abs(p.dvv.z() + 2.0), std::abs(p.duv.z() + 0.3)});
                    }
                }
            }
        }
        return largest;
    };
    CHECK(largest_error(*cage.topology) < 1e-12);
    // Natural ends have no second derivative at the border.
    CHECK(largest_error(cage.topology->with(CreaseRule::CatmullClark)) > 3.9);
}

TEST_CASE("surfaces with runouts are twice differentiable beside creases and meet on them",
          "[subd][oracle]") {
    const mesh::Cage cage = creased_sheet(8, 6, CreaseRule::ParabolicRunout);
    const mesh::Topology& t = *cage.topology;
    REQUIRE(t.has_runouts());
    const subd::LimitEvaluator evaluator(cage.topology);
    const auto at_side = [&](CornerId c, double along) {
        const FaceId f = t.face(c);
        constexpr double from[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        const int i = c.value - t.corners(f)[0].value, j = (i + 1) % 4;
        return evaluator.evaluate(cage.points, {f, from[i][0] + along * (from[j][0] - from[i][0]),
                                                from[i][1] + along * (from[j][1] - from[i][1])});
    };
    int smooth = 0, sharp = 0;
    for (const mesh::EdgeId e : t.edges()) {
        if (t.is_boundary(e)) continue;
        for (const double along : {0.0, 0.3, 1.0}) {
            // Faces of the grid have the same axes.
            const auto a = at_side(t.corner(e), along), b = at_side(t.twin(t.corner(e)), 1 - along);
            CHECK((a.position - b.position).norm() < 1e-13);
            if (mesh::is_sharp(t, e)) {
                ++sharp;
                continue;
            }
            ++smooth;
            CHECK((a.du - b.du).norm() + (a.dv - b.dv).norm() < 1e-12);
            CHECK((a.duu - b.duu).norm() + (a.duv - b.duv).norm() + (a.dvv - b.dvv).norm() < 1e-11);
        }
    }
    CHECK(smooth > 200);
    CHECK(sharp == 18);
}

TEST_CASE("with runouts a border costs half an order of approximation, not one and a half",
          "[subd][oracle]") {
    const auto order = [](CreaseRule rule) {
        return std::log2(error_of_fit(8, rule) / error_of_fit(16, rule));
    };
    CHECK(order(CreaseRule::ParabolicRunout) > 3.4);
    CHECK(order(CreaseRule::CatmullClark) < 2.6);
    CHECK(error_of_fit(16, CreaseRule::ParabolicRunout) <
          0.2 * error_of_fit(16, CreaseRule::CatmullClark));
}

TEST_CASE("lines have runouts where three regular faces lie between creases", "[subd]") {
    const auto runouts = [](int nu, int nv) {
        return count_runouts(
            *test::grid(nu, nv, with_corners(CreaseRule::ParabolicRunout)).topology);
    };
    CHECK(runouts(2, 2) == 0);
    // Four lines with two ends each, in one direction and in both.
    CHECK(runouts(3, 2) == 6);
    CHECK(runouts(3, 3) == 16);
    // Corners that are not tagged are smooth, and irregular.
    mesh::TopologyInput smooth_corners;
    smooth_corners.crease_rule = CreaseRule::ParabolicRunout;
    CHECK(count_runouts(*test::grid(4, 4, smooth_corners).topology) == 0);
    CHECK(count_runouts(*test::grid(8, 8, smooth_corners).topology) > 0);
    CHECK(count_runouts(*test::grid(3, 3, with_corners(CreaseRule::CatmullClark)).topology) == 0);
    // Meshes of other polygons are refined before they become patches.
    const mesh::Cage triangle =
        test::make_cage({{0, 0, 0},
                         {1, 0, 0},
                         {2, 0, 0},
                         {3, 0, 0},
                         {0, 1, 0},
                         {1, 1, 0},
                         {2, 1, 0},
                         {3, 1, 0},
                         {4, 0, 0}},
                        {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 8, 7}},
                        with_corners(CreaseRule::ParabolicRunout));
    CHECK_FALSE(triangle.topology->has_runouts());
    CHECK(triangle.topology->crease_rule() == CreaseRule::ParabolicRunout);
}

TEST_CASE("operators and masks see the same runouts", "[subd]") {
    const mesh::Cage cage = creased_sheet(6, 5, CreaseRule::ParabolicRunout);
    const mesh::Topology& t = *cage.topology;
    const subd::ParameterSet set{{0.0, 0.0}, {0.3, 0.8}, {1.0, 0.5}};
    std::vector<subd::Site> sites;
    for (const FaceId f : t.faces()) sites.push_back({.face = f});
    geom::Points limit;
    subd::LimitOperator(t, {set}, sites).apply(cage.points, limit);
    const subd::LimitEvaluator evaluator(cage.topology);
    Eigen::Index row = 0;
    for (const FaceId f : t.faces()) {
        for (const Eigen::Vector2d& p : set) {
            const Vec3 expected = evaluator.position(cage.points, {f, p.x(), p.y()});
            CHECK((limit.row(row++).transpose() - expected).norm() < 1e-13);
            CHECK(std::abs(evaluator.mask({f, p.x(), p.y()}).rows.sum() - 1.0) < 1e-13);
        }
    }
}

TEST_CASE("refinement keeps a limit surface with runouts", "[subd][oracle]") {
    const mesh::Cage coarse = tube(6, 5, CreaseRule::ParabolicRunout);
    const mesh::Cage fine = subd::refine(coarse, 1);
    REQUIRE(coarse.topology->has_runouts());
    const subd::LimitEvaluator before(coarse.topology), after(fine.topology);
    for (const FaceId f : coarse.topology->faces()) {
        for (const double u : {0.1, 0.4}) {
            for (const double v : {0.0, 0.3, 0.5}) {
                // The first child keeps the axes.
                const Vec3 a = before.position(coarse.points, {f, u, v});
                const Vec3 b = after.position(fine.points, {FaceId{4 * f.value}, 2 * u, 2 * v});
                CHECK((a - b).norm() < 1e-13);
            }
        }
    }
    // Where there are none, finer meshes have none either.
    const mesh::Cage short_tube = tube(6, 2, CreaseRule::ParabolicRunout);
    CHECK_FALSE(subd::refine(short_tube, 1).topology->has_runouts());
}

TEST_CASE("the rule at creases is kept in files and parts", "[mesh]") {
    const mesh::Cage cage = creased_sheet(6, 5, CreaseRule::ParabolicRunout);
    std::istringstream text(mesh::obj_text(cage));
    const mesh::Cage read = mesh::read_obj(text, "sheet").cage;
    CHECK(count_runouts(*read.topology) == count_runouts(*cage.topology));
    CHECK(read.points == cage.points);
    const mesh::Cage both = mesh::joined({cage, cage});
    CHECK(count_runouts(*both.topology) == 2 * count_runouts(*cage.topology));
    CHECK(mesh::connected_parts(both)[1].topology->crease_rule() == CreaseRule::ParabolicRunout);
    std::istringstream wrong(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n#patchwright crease-rule other\n");
    CHECK_THROWS_WITH(mesh::read_obj(wrong, "wrong"),
                      Catch::Contains("line 5") && Catch::Contains("runout or catmull-clark"));
}
