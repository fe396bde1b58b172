#include "support/cages.h"

#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <random>

using namespace patchwright;
using geom::Vec3;
using mesh::FaceId;

namespace {

mesh::TopologyInput input_of(const mesh::Topology& t) {
    mesh::TopologyInput input;
    input.vertex_count = t.vertex_count();
    input.boundary_rule = t.boundary_rule();
    for (const FaceId f : t.faces()) {
        input.face_sizes.push_back(t.size(f));
        for (const mesh::CornerId c : t.corners(f)) {
            input.face_vertices.push_back(t.vertex(c).value);
        }
    }
    for (const mesh::EdgeId e : t.edges()) {
        if (t.tagged_sharpness(e) > 0.0) {
            input.creases.push_back({t.start(e).value, t.end(e).value, t.tagged_sharpness(e)});
        }
    }
    for (const mesh::VertexId v : t.vertices()) {
        if (t.tagged_sharpness(v) > 0.0) input.corners.push_back({v.value, t.tagged_sharpness(v)});
    }
    return input;
}

mesh::Cage cage_of(unsigned seed) {
    return test::random_cage(seed, {.open = seed % 2 == 1, .semi_sharp = seed % 3 == 0});
}

constexpr double parameters[][2] = {{0, 0},     {1, 0},    {1, 1},     {0, 1},        {0.5, 0},
                                    {0.3, 0.8}, {0.9, .2}, {1e-6, .4}, {0.02, 0.001}, {1, 0.7}};

}  // namespace

TEST_CASE("numbers of vertices, order of faces and their first vertices do not matter", "[subd]") {
    for (unsigned seed = 0; seed < 24; ++seed) {
        CAPTURE(seed);
        const mesh::Cage cage = cage_of(seed);
        const mesh::Topology& t = *cage.topology;
        std::mt19937 random(seed);
        std::vector<int> vertex(std::size_t(t.vertex_count())), face(std::size_t(t.face_count()));
        std::iota(vertex.begin(), vertex.end(), 0);
        std::iota(face.begin(), face.end(), 0);
        std::shuffle(vertex.begin(), vertex.end(), random);
        std::shuffle(face.begin(), face.end(), random);  // new face k is old face[k]
        mesh::TopologyInput input = input_of(t);
        input.face_sizes.clear();
        input.face_vertices.clear();
        std::vector<int> turn;  // new corner i is old corner i + turn
        for (const int f : face) {
            const int n = t.size(FaceId{f});
            turn.push_back(int(random() % unsigned(n)));
            input.face_sizes.push_back(n);
            for (int i = 0; i < n; ++i) {
                const auto c = t.corners(FaceId{f})[(i + turn.back()) % n];
                input.face_vertices.push_back(vertex[t.vertex(c).index()]);
            }
        }
        for (auto& tag : input.creases) {
            tag.v0 = vertex[std::size_t(tag.v0)];
            tag.v1 = vertex[std::size_t(tag.v1)];
        }
        for (auto& tag : input.corners) tag.vertex = vertex[std::size_t(tag.vertex)];
        geom::Points points(cage.points.rows(), 3);
        for (std::size_t v = 0; v < vertex.size(); ++v) {
            points.row(vertex[v]) = cage.points.row(Eigen::Index(v));
        }
        const auto shuffled = std::make_shared<const mesh::Topology>(input);
        const subd::LimitEvaluator before(cage.topology), after(shuffled);
        for (std::size_t k = 0; k < face.size(); ++k) {
            const int n = t.size(FaceId{face[k]});
            for (const auto& [u, v] : parameters) {
                subd::Location old{FaceId{face[k]}, u, v};
                subd::Location now{FaceId{int(k)}, u, v};
                if (n == 4) {
                    // One turn takes (u, v) of the new square to (1 - v, u) of the old.
                    for (int i = 0; i < turn[k]; ++i) {
                        old = {old.face, 1.0 - old.v, old.u};
                    }
                } else {
                    now.sector = 1;
                    old.sector = (1 + turn[k]) % n;
                }
                const subd::LimitPoint a = before.evaluate(cage.points, old);
                const subd::LimitPoint b = after.evaluate(points, now);
                CAPTURE(face[k], u, v);
                CHECK(a.smoothness == b.smoothness);
                CHECK((a.position - b.position).norm() < 1e-13);
                // Eigenvectors and inverse powers of 1e-6 cost digits.
                if (a.smoothness == subd::Smoothness::Derivatives) {
                    CHECK((a.normal - b.normal).norm() < 1e-8);
                } else {
                    CHECK((a.normal - b.normal).norm() < 1e-6);
                }
            }
        }
    }
}

TEST_CASE("affine maps of the control points are affine maps of the surface", "[subd]") {
    Eigen::Matrix3d linear;
    linear << 1.5, 0.2, -0.3, 0.1, 0.7, 0.4, -0.2, 0.3, 1.1;
    const Eigen::RowVector3d shift(3, -2, 5);
    for (unsigned seed = 0; seed < 12; ++seed) {
        CAPTURE(seed);
        const mesh::Cage cage = cage_of(seed);
        const geom::Points mapped = (cage.points * linear.transpose()).rowwise() + shift;
        const subd::LimitEvaluator evaluator(cage.topology);
        for (const FaceId f : cage.topology->faces()) {
            for (const auto& [u, v] : parameters) {
                const subd::LimitPoint a = evaluator.evaluate(cage.points, {f, u, v});
                const subd::LimitPoint b = evaluator.evaluate(mapped, {f, u, v});
                CHECK((b.position - linear * a.position - shift.transpose()).norm() < 1e-13 * 10);
                CHECK((b.du - linear * a.du).norm() < 1e-10 * (1 + a.du.norm()));
                CHECK((b.dvv - linear * a.dvv).norm() < 1e-10 * (1e3 + a.dvv.norm()));
            }
        }
    }
}

TEST_CASE("masks times subdivision matrices are masks of the coarser level", "[subd][oracle]") {
    for (unsigned seed = 0; seed < 8; ++seed) {
        CAPTURE(seed);
        const mesh::Cage cage = cage_of(seed);
        const subd::Refinement one = subd::refine(*cage.topology);
        const subd::Refinement two = subd::refine(*one.topology);
        const subd::Stencils both = subd::multiply(two.stencils, one.stencils);
        CHECK((both.apply(cage.points) - two.stencils.apply(one.stencils.apply(cage.points)))
                  .cwiseAbs()
                  .maxCoeff() < 1e-14);
        // <S x, y> = <x, S^T y>
        const geom::Points y = geom::Points::Random(both.rows(), 3);
        CHECK(both.apply(cage.points).cwiseProduct(y).sum() ==
              Approx(cage.points.cwiseProduct(both.transposed().apply(y)).sum()).epsilon(1e-12));
        const subd::LimitEvaluator coarse(cage.topology), fine(two.topology);
        int first = 0;  // of the grandchildren of face f
        for (const FaceId f : cage.topology->faces()) {
            const int n = cage.topology->size(f);
            // The first grandchild lies at the first vertex: a quarter of the square, or half a
            // sector.
            const double scale = n == 4 ? 0.25 : 0.5;
            const subd::Mask a =
                subd::relative_to_coarser(fine.mask({FaceId{first}, 0.3, 0.6}, 2), both);
            const subd::Mask b = coarse.mask({f, 0.3 * scale, 0.6 * scale}, 2);
            Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(6, cage.topology->vertex_count());
            for (std::size_t k = 0; k < a.vertices.size(); ++k) {
                dense.col(a.vertices[k]) += a.rows.col(Eigen::Index(k));
            }
            for (int row = 0; row < 6; ++row) {
                dense.row(row) /= std::pow(scale, row == 0 ? 0 : row < 3 ? 1 : 2);
            }
            for (std::size_t k = 0; k < b.vertices.size(); ++k) {
                dense.col(b.vertices[k]) -= b.rows.col(Eigen::Index(k));
            }
            CHECK(dense.cwiseAbs().maxCoeff() < 1e-12);
            first += 4 * n;
        }
    }
}
