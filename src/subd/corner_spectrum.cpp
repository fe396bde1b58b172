#include "subd/corner_spectrum.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace patchwright::subd {

namespace {

// Eigenvalues closer than this are one: a double one comes out of the iteration split by the root
// of the rounding. Those of different frequencies differ by more than 1e-3 up to valence 50.
constexpr double same_eigenvalue = 1e-6;
constexpr double no_component = 1e-9;

/// Distinct real eigenvalues below 1, largest modulus first.
std::vector<double> contracting_eigenvalues(const Eigen::MatrixXd& matrix) {
    const Eigen::VectorXcd all = Eigen::EigenSolver<Eigen::MatrixXd>(matrix, false).eigenvalues();
    std::vector<double> sorted;
    for (const auto& value : all) {
        if (std::abs(value.imag()) < same_eigenvalue && std::abs(value) < 1.0 - same_eigenvalue) {
            sorted.push_back(value.real());
        }
    }
    std::sort(sorted.begin(), sorted.end(),
              [](double a, double b) { return std::abs(a) > std::abs(b); });
    std::vector<double> distinct;
    for (std::size_t i = 0; i < sorted.size();) {
        // The mean of a split multiple eigenvalue is accurate to rounding again.
        double sum = 0.0;
        std::size_t j = i;
        while (j < sorted.size() && std::abs(sorted[j] - sorted[i]) < same_eigenvalue)
            sum += sorted[j++];
        distinct.push_back(sum / double(j - i));
        i = j;
    }
    return distinct;
}

/// Basis of the null space, as columns.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& matrix) {
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(matrix, Eigen::ComputeFullV);
    const auto& values = svd.singularValues();
    Eigen::Index rank = 0;
    while (rank < values.size() && values[rank] > 1e-8) ++rank;
    return svd.matrixV().rightCols(matrix.cols() - rank);
}

/// The projection onto the eigenspace along all others; empty where the matrix is defective there.
std::optional<Eigen::MatrixXd> eigenprojection(const Eigen::MatrixXd& matrix, double eigenvalue) {
    const auto shifted =
        matrix - eigenvalue * Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
    const Eigen::MatrixXd right = null_space(shifted);
    const Eigen::MatrixXd left = null_space(shifted.transpose());
    if (right.cols() == 0 || right.cols() != left.cols()) return std::nullopt;
    // Both bases are orthonormal: a product near singular means that eigenvectors are missing, as
    // for the eigenvalue 1/2 of corners with two faces, where convergence is only like 1 over the
    // level.
    Eigen::FullPivLU<Eigen::MatrixXd> product(left.transpose() * right);
    product.setThreshold(1e-5);
    if (!product.isInvertible()) return std::nullopt;
    return right * product.solve(left.transpose());
}

bool parallel(const Eigen::RowVectorXd& a, const Eigen::RowVectorXd& b) {
    return (a / a.norm() - b * (a.dot(b) / (a.norm() * b.squaredNorm()))).norm() < 1e-7;
}

}  // namespace

Eigen::RowVectorXd limit_row(const Eigen::MatrixXd& matrix) {
    const Eigen::Index n = matrix.rows();
    Eigen::MatrixXd system(n + 1, n);
    system.topRows(n) = matrix.transpose() - Eigen::MatrixXd::Identity(n, n);
    system.row(n).setOnes();
    return system.colPivHouseholderQr().solve(Eigen::VectorXd::Unit(n + 1, n)).transpose();
}

TangentRows tangent_rows(const Eigen::MatrixXd& matrix, const CornerProbes& probes) {
    TangentRows result;
    std::optional<Eigen::RowVectorXd> u, v;
    Eigen::MatrixXd inside = Eigen::MatrixXd::Zero(probes.inside.rows(), matrix.cols());
    for (const double eigenvalue : contracting_eigenvalues(matrix)) {
        const auto projection = eigenprojection(matrix, eigenvalue);
        if (!projection) return {};
        const Eigen::RowVectorXd in_u = probes.u * *projection;
        const Eigen::RowVectorXd in_v = probes.v * *projection;
        inside += probes.inside * *projection;
        if (!u && in_u.norm() > no_component) {
            u = in_u;
            result.eigenvalue = eigenvalue;
        }
        if (!v && in_v.norm() > no_component) v = in_v;
        if (!u || !v) continue;
        if (parallel(*u, *v)) return {};
        result.rows.resize(2, matrix.cols());
        result.rows << *u, *v;
        // Inside the face the surface must not leave the plane of its sides.
        const Eigen::MatrixXd plane = result.rows.transpose();
        const Eigen::MatrixXd off =
            inside.transpose() - plane * plane.colPivHouseholderQr().solve(inside.transpose());
        return off.norm() < 1e-7 * inside.norm() ? result : TangentRows{};
    }
    return {};
}

}  // namespace patchwright::subd
