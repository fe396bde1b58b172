#include "fit/warp/lattice.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace patchwright::fit {

namespace {

using geom::Vec3;

/// Weights of the four uniform cubic B-splines at 0 <= t <= 1 of their span.
std::array<double, 4> cubic(double t) {
    const double s = 1.0 - t;
    return {s * s * s / 6.0, (4.0 + t * t * (3.0 * t - 6.0)) / 6.0,
            (4.0 + s * s * (3.0 * s - 6.0)) / 6.0, t * t * t / 6.0};
}

int node(const std::array<int, 3>& cells, int i, int j, int k) {
    return (i * (cells[1] + 3) + j) * (cells[2] + 3) + k;
}

/// Sum of squared second differences along the axes and mixed ones, by the number of nodes: those
/// of a linear field are zero.
Eigen::MatrixXd bending(const std::array<int, 3>& cells) {
    const std::array<int, 3> n{cells[0] + 3, cells[1] + 3, cells[2] + 3};
    const int count = n[0] * n[1] * n[2];
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
    const auto add = [&](const auto& terms, double weight) {
        for (const auto& [a, x] : terms)
            for (const auto& [b, y] : terms) sum(a, b) += weight * x * y;
    };
    using Term = std::pair<int, double>;
    const auto at = [&](std::array<int, 3> p, int axis, int step) {
        p[std::size_t(axis)] += step;
        return p;
    };
    const auto id = [&](const std::array<int, 3>& p) { return node(cells, p[0], p[1], p[2]); };
    for (int i = 0; i < n[0]; ++i)
        for (int j = 0; j < n[1]; ++j)
            for (int k = 0; k < n[2]; ++k)
                for (int a = 0; a < 3; ++a) {
                    const std::array<int, 3> p{i, j, k};
                    const auto has_next = [&](int axis) {
                        return p[std::size_t(axis)] + 1 < n[std::size_t(axis)];
                    };
                    if (p[std::size_t(a)] > 0 && has_next(a))
                        add(
                            std::array<Term, 3>{
                                Term{id(at(p, a, -1)), 1.0}, {id(p), -2.0}, {id(at(p, a, 1)), 1.0}},
                            1.0);
                    for (int b = 0; b < a; ++b)
                        if (has_next(a) && has_next(b))
                            add(std::array<Term, 4>{Term{id(p), 1.0},
                                                    {id(at(p, a, 1)), -1.0},
                                                    {id(at(p, b, 1)), -1.0},
                                                    {id(at(at(p, a, 1), b, 1)), 1.0}},
                                2.0);
                }
    return sum / double(count);
}

}  // namespace

DisplacementBasis DisplacementBasis::affine(const geom::Box3& box) {
    DisplacementBasis result;
    result.is_affine_ = true;
    result.origin_ = box.centre();
    result.cell_.setConstant(0.5 * (box.max - box.min).maxCoeff());
    result.stiffness_ = Eigen::Vector4d(0.0, 1.0, 1.0, 1.0).asDiagonal();
    return result;
}

int DisplacementBasis::lattice_size(const geom::Box3& box, int cells) {
    const Vec3 sides = box.max - box.min;
    int nodes = 1;
    for (int axis = 0; axis < 3; ++axis)
        nodes *= std::max(1, int(std::lround(sides[axis] / sides.maxCoeff() * cells))) + 3;
    return nodes;
}

DisplacementBasis DisplacementBasis::lattice(const geom::Box3& box, int cells) {
    DisplacementBasis result;
    const Vec3 sides = box.max - box.min;
    const double size = sides.maxCoeff() / cells;
    result.origin_ = box.min;
    for (int axis = 0; axis < 3; ++axis) {
        int& count = result.cells_[std::size_t(axis)];
        count = std::max(1, int(std::lround(sides[axis] / size)));
        // A flat box has cells as thick as they are wide.
        result.cell_[axis] = sides[axis] > 0.5 * size ? sides[axis] / count : size;
        result.origin_[axis] = box.centre()[axis] - 0.5 * count * result.cell_[axis];
    }
    result.stiffness_ = bending(result.cells_);
    return result;
}

DisplacementBasis::Values DisplacementBasis::values(const geom::Points& points) const {
    Values result(points.rows(), size());
    result.reserve(Eigen::VectorXi::Constant(points.rows(), is_affine_ ? 4 : 64));
    for (Eigen::Index row = 0; row < points.rows(); ++row) {
        const Vec3 x = (points.row(row).transpose() - origin_).cwiseQuotient(cell_);
        if (is_affine_) {
            result.insert(row, 0) = 1.0;
            for (int axis = 0; axis < 3; ++axis) result.insert(row, axis + 1) = x[axis];
            continue;
        }
        std::array<int, 3> first{};
        std::array<std::array<double, 4>, 3> w;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double along = x[Eigen::Index(axis)];
            first[axis] = int(std::clamp(std::floor(along), 0.0, double(cells_[axis] - 1)));
            w[axis] = cubic(along - first[axis]);
        }
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                for (int k = 0; k < 4; ++k)
                    result.insert(row, node(cells_, first[0] + i, first[1] + j, first[2] + k)) =
                        w[0][std::size_t(i)] * w[1][std::size_t(j)] * w[2][std::size_t(k)];
    }
    result.makeCompressed();
    return result;
}

}  // namespace patchwright::fit
