#include "cage/blocks/flat_piece.h"

#include "cage/blocks/layout_refused.h"
#include "geom/sparse_solve.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Mean value weights of triangles without an angle are cut at this: a matrix of such ones would be
// singular in double precision.
constexpr double least_tangent = 1e-3;

/// Half the angle's tangent between two directions.
double half_tangent(const Vec3& a, const Vec3& b) {
    const double product = a.norm() * b.norm();
    const double sine = a.cross(b).norm(), cosine = a.dot(b);
    return sine / std::max(product + cosine, 1e-9 * product);
}

}  // namespace

FlatPiece::FlatPiece(std::vector<Vec3> points, std::vector<std::array<int, 3>> triangles,
                     std::vector<Vec2> border)
    : points_(std::move(points)), triangles_(std::move(triangles)), flat_(std::move(border)) {
    const int fixed = int(flat_.size()), count = int(points_.size()) - fixed;
    flat_.resize(points_.size(), Vec2::Zero());
    if (count == 0) return;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(count, 2);
    const auto add = [&](int i, int j, double weight) {
        if (i < fixed) return;
        entries.emplace_back(i - fixed, i - fixed, weight);
        if (j < fixed)
            right.row(i - fixed) += weight * flat_[std::size_t(j)].transpose();
        else
            entries.emplace_back(i - fixed, j - fixed, -weight);
    };
    for (const auto& t : triangles_) {
        for (std::size_t k = 0; k < 3; ++k) {
            const int i = t[k], a = t[(k + 1) % 3], b = t[(k + 2) % 3];
            const Vec3 to_a = points_[std::size_t(a)] - points_[std::size_t(i)];
            const Vec3 to_b = points_[std::size_t(b)] - points_[std::size_t(i)];
            const double tangent =
                std::clamp(half_tangent(to_a, to_b), least_tangent, 1.0 / least_tangent);
            add(i, a, tangent / std::max(to_a.norm(), 1e-12));
            add(i, b, tangent / std::max(to_b.norm(), 1e-12));
        }
    }
    Eigen::SparseMatrix<double> matrix(count, count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const auto inner = geom::solve_sparse(matrix, right);
    if (!inner) throw LayoutRefused{"a piece cannot be laid flat"};
    for (int i = 0; i < count; ++i) flat_[std::size_t(fixed + i)] = inner->row(i).transpose();
}

FlatPiece::SurfacePoint FlatPiece::at(const Vec2& p) const {
    double best = -std::numeric_limits<double>::infinity();
    SurfacePoint place{Vec3::Zero(), Vec3::UnitZ(), 0};
    for (std::size_t number = 0; number < triangles_.size(); ++number) {
        const auto& t = triangles_[number];
        const Vec2 &a = flat_[std::size_t(t[0])], &b = flat_[std::size_t(t[1])],
                   &c = flat_[std::size_t(t[2])];
        const double area = cross(b - a, c - a);
        if (!(area > 0.0)) continue;
        const std::array<double, 3> w{cross(b - p, c - p) / area, cross(c - p, a - p) / area,
                                      cross(a - p, b - p) / area};
        const double least = *std::min_element(w.begin(), w.end());
        // Outside by how far, not by what share of a triangle.
        const double inside = least < 0.0 ? least * std::sqrt(area) : least;
        if (inside <= best) continue;
        best = inside;
        const Vec3 &pa = points_[std::size_t(t[0])], &pb = points_[std::size_t(t[1])],
                   &pc = points_[std::size_t(t[2])];
        place.point = w[0] * pa + w[1] * pb + w[2] * pc;
        place.triangle = int(number);
        place.normal = (pb - pa).cross(pc - pa).normalized();
        if (best >= 0.0) break;
    }
    return place;
}

}  // namespace patchwright::cage
