#include "subd/corner_spectrum.h"

#include "geom/sparse_solve.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace patchwright::subd {

namespace {

using Matrix = Eigen::MatrixXd;
using Row = Eigen::RowVectorXd;
using Svd = Eigen::JacobiSVD<Matrix, Eigen::NoQRPreconditioner>;  // of square matrices

// Eigenvalues closer than this are one: a double one comes out of the iteration split by the root
// of the rounding. Those of different frequencies differ by more than 1e-3 up to valence 50.
constexpr double same_eigenvalue = 1e-6;
// Relative to a row: smaller parts along an eigenspace are rounding of its projection.
constexpr double no_component = 1e-8;
constexpr int largest_block = 3;  // of the Jordan form
// Singular values below this are zero: matrices have entries of order 1, and powers up to
// largest_block of a shifted one keep about ten digits.
constexpr double zero_singular_value = 1e-9;
// Relative differences of forms and directions that are equal but for the rounding of projections,
// which eigenvectors of close eigenvalues amplify (derivatives_test, valences up to 20).
constexpr double same_direction = 1e-6, in_plane_tolerance = 1e-5;

/// Distinct real eigenvalues below 1, largest modulus first.
std::vector<double> contracting_eigenvalues(const Matrix& matrix) {
    const Eigen::VectorXcd all = Eigen::EigenSolver<Matrix>(matrix, false).eigenvalues();
    std::vector<double> sorted;
    for (const auto& value : all) {
        if (std::abs(value) < 1.0 - same_eigenvalue && std::abs(value) > same_eigenvalue) {
            // A double eigenvalue may come out as a pair with rounding in the imaginary parts.
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
Matrix null_space(const Matrix& matrix) {
    const Svd svd(matrix, Eigen::ComputeFullV);
    const auto& values = svd.singularValues();
    Eigen::Index rank = 0;
    while (rank < values.size() && values[rank] > zero_singular_value) ++rank;
    return svd.matrixV().rightCols(matrix.cols() - rank);
}

/// A part of the k-th power of a matrix: eigenvalue^k k^degree map.
struct PowerPart {
    double eigenvalue;
    int degree;
    Matrix map;
};

/// All parts that belong to one eigenvalue, highest degree first; none where the spectrum is not
/// resolved.
std::optional<std::vector<PowerPart>> power_parts(const Matrix& matrix, double eigenvalue) {
    const Matrix shifted = matrix - eigenvalue * Matrix::Identity(matrix.rows(), matrix.cols());
    Matrix power = shifted;
    Matrix right = null_space(power);
    int block = 1;
    for (; block < largest_block; ++block) {
        const Matrix next = power * shifted;
        Matrix larger = null_space(next);
        if (larger.cols() == right.cols()) break;
        power = next;
        right = std::move(larger);
    }
    const Matrix left = null_space(power.transpose());
    if (right.cols() == 0 || right.cols() != left.cols()) return std::nullopt;
    Svd product(left.transpose() * right, Eigen::ComputeFullU | Eigen::ComputeFullV);
    product.setThreshold(same_direction);
    if (product.rank() < right.cols()) return std::nullopt;
    const Matrix projection = right * product.solve(left.transpose());
    // (eigenvalue + nilpotent)^k = eigenvalue^k exp(k log(1 + nilpotent / eigenvalue)).
    const Matrix nilpotent = shifted * projection / eigenvalue;
    Matrix logarithm = nilpotent;
    if (block > 2) logarithm -= 0.5 * nilpotent * nilpotent;
    std::vector<PowerPart> parts;
    Matrix term = projection;
    for (int degree = 0; degree < block; ++degree) {
        parts.insert(parts.begin(), {eigenvalue, degree, term});
        term = (term * logarithm / (degree + 1)).eval();
    }
    return parts;
}

/// How a product of two parts grows with the level; larger ones come first.
struct GrowthOrder {
    double factor;
    int degree;

    GrowthOrder(const PowerPart& a, const PowerPart& b)
        : factor(a.eigenvalue * b.eigenvalue), degree(a.degree + b.degree) {}
    [[nodiscard]] bool same(const GrowthOrder& other) const {
        return std::abs(factor - other.factor) < same_eigenvalue && degree == other.degree;
    }
    [[nodiscard]] bool before(const GrowthOrder& other) const {
        const double difference = std::abs(factor) - std::abs(other.factor);
        return std::abs(difference) > same_eigenvalue ? difference > 0.0 : degree > other.degree;
    }
};

Matrix wedge(const Row& a, const Row& b) { return a.transpose() * b - b.transpose() * a; }

/// The leading term of du ^ dv at one point among the products of growth `g`.
Matrix leading_form(const std::vector<PowerPart>& parts, const GrowthOrder& g, const Row& du,
                    const Row& dv) {
    Matrix form = Matrix::Zero(du.size(), du.size());
    for (const PowerPart& a : parts) {
        for (const PowerPart& b : parts) {
            if (g.same(GrowthOrder(a, b))) form += wedge(du * a.map, dv * b.map);
        }
    }
    return form;
}

/// The common direction of the leading terms of all points; empty when they differ, zero when they
/// vanish.
std::optional<Matrix> common_form(const std::vector<PowerPart>& parts, const GrowthOrder& g,
                                  const CornerProbes& probes) {
    std::vector<Matrix> forms;
    int vanishing = 0;
    for (Eigen::Index p = 0; p < probes.du.rows(); ++p) {
        const Row du = probes.du.row(p), dv = probes.dv.row(p);
        Matrix form = leading_form(parts, g, du, dv);
        const double norm = form.norm();
        const bool vanishes = norm < no_component * du.norm() * dv.norm();
        vanishing += vanishes ? 1 : 0;
        forms.push_back(vanishes ? Matrix::Zero(du.size(), du.size()).eval() : Matrix(form / norm));
    }
    if (vanishing > 0) {
        return vanishing == static_cast<int>(forms.size()) ? std::optional(forms[0]) : std::nullopt;
    }
    for (const Matrix& form : forms) {
        if ((form - forms[0]).norm() > same_direction) return std::nullopt;
    }
    return forms[0];
}

/// The leading direction of a side: the first part that it has a component in.
std::pair<Row, double> leading_direction(const std::vector<PowerPart>& parts, const Row& side) {
    for (const PowerPart& part : parts) {
        const Row direction = side * part.map;
        if (direction.norm() > no_component * side.norm()) return {direction, part.eigenvalue};
    }
    return {Row::Zero(side.size()), 0.0};
}

/// Two rows that span the plane of the form, turned like it.
TangentRows rows_of(const Matrix& form, const std::vector<PowerPart>& parts,
                    const CornerProbes& probes) {
    const Svd svd(form, Eigen::ComputeFullU);
    if (svd.singularValues().size() > 2 &&
        svd.singularValues()[2] > same_direction * svd.singularValues()[0]) {
        return {};
    }
    const Matrix plane = svd.matrixU().leftCols<2>();
    const auto [along_u, eigenvalue] = leading_direction(parts, probes.u);
    const auto [along_v, unused] = leading_direction(parts, probes.v);
    const auto in_plane = [&](const Row& r) {
        return r.norm() > 0.0 &&
               (r - r * plane * plane.transpose()).norm() < in_plane_tolerance * r.norm();
    };
    TangentRows result;
    if (!in_plane(along_u)) return result;
    result.eigenvalue = eigenvalue;
    result.rows.resize(2, form.cols());
    result.rows.row(0) = along_u;
    const Matrix sides = wedge(along_u, along_v);
    if (in_plane(along_v) && sides.norm() > same_direction * along_u.norm() * along_v.norm() &&
        sides.cwiseProduct(form).sum() > 0.0) {
        result.rows.row(1) = along_v;
    } else {
        // For a form c (x ^ y) with y at right angles to x the product with x is c |x|^2 y.
        const Row across = along_u * form;
        result.rows.row(1) = across * (along_u.norm() / across.norm());
    }
    return result;
}

}  // namespace

Eigen::RowVectorXd limit_row(const Stencils& matrix) {
    const int n = matrix.rows();
    // The sum in place of one of the equations x (matrix - 1) = 0, which the others imply.
    std::vector<Eigen::Triplet<double>> entries;
    for (int row = 0; row < n; ++row) {
        for (auto e = matrix.begin[std::size_t(row)]; e < matrix.begin[std::size_t(row) + 1]; ++e) {
            const int column = matrix.index[std::size_t(e)];
            if (column + 1 < n) entries.emplace_back(column, row, matrix.weight[std::size_t(e)]);
        }
        if (row + 1 < n) entries.emplace_back(row, row, -1.0);
        entries.emplace_back(n - 1, row, 1.0);
    }
    Eigen::SparseMatrix<double> system(n, n);
    system.setFromTriplets(entries.begin(), entries.end());
    // Not singular: 1 is a simple eigenvalue.
    return geom::solve_sparse(system, Eigen::VectorXd::Unit(n, n - 1)).value().transpose();
}

Matrix growing_part(const Matrix& matrix, double bound) {
    Matrix sum = Matrix::Zero(matrix.rows(), matrix.cols());
    for (const double eigenvalue : contracting_eigenvalues(matrix)) {
        if (std::abs(eigenvalue) < bound + same_eigenvalue) break;
        if (const auto parts = power_parts(matrix, eigenvalue)) sum += parts->back().map;
    }
    return sum;
}

TangentRows tangent_rows(const Matrix& matrix, const CornerProbes& probes, double largest) {
    std::vector<double> eigenvalues = contracting_eigenvalues(matrix);
    std::erase_if(eigenvalues, [&](double e) { return std::abs(e) > largest + same_eigenvalue; });
    std::vector<PowerPart> parts;
    std::vector<GrowthOrder> done;
    for (std::size_t known = 0; known < eigenvalues.size(); ++known) {
        auto more = power_parts(matrix, eigenvalues[known]);
        if (!more) return {};
        parts.insert(parts.end(), more->begin(), more->end());
        // Products that no later eigenvalue can reach are complete.
        const double reach = known + 1 < eigenvalues.size()
                                 ? std::abs(eigenvalues[0] * eigenvalues[known + 1])
                                 : 0.0;
        std::vector<GrowthOrder> complete;
        for (const PowerPart& a : parts) {
            for (const PowerPart& b : parts) {
                const GrowthOrder g(a, b);
                if (std::abs(g.factor) > reach + same_eigenvalue) complete.push_back(g);
            }
        }
        std::sort(complete.begin(), complete.end(),
                  [](const GrowthOrder& a, const GrowthOrder& b) { return a.before(b); });
        for (const GrowthOrder& g : complete) {
            const auto same = [&](const GrowthOrder& other) { return g.same(other); };
            if (std::any_of(done.begin(), done.end(), same)) continue;
            done.push_back(g);
            const auto form = common_form(parts, g, probes);
            if (!form) return {};
            if (form->norm() > 0.0) return rows_of(*form, parts, probes);
        }
    }
    return {};
}

}  // namespace patchwright::subd
