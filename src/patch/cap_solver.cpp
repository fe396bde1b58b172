#include "patch/cap_solver.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cmath>
#include <vector>

namespace patchwright::patch {

namespace {

using Matrix = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;
using Cholesky = Eigen::SimplicialLDLT<Sparse>;
using Row = Eigen::RowVectorXd;

/// Which unknown is which row of the vector of unknowns; -1 where there is none.
struct Unknowns {
    int x = -1, y = -1;  ///< the two vectors that span the tangent plane
    int twist = -1;      ///< point (1, 1) of the first face
    int dart = -1;       ///< point (2, 0) on a dart's sharp edge
    /// Plus the number of a smooth edge: half the difference of points (2, 1) and (1, 2) beside it.
    int spread = 0;
    int first_side = -1, last_side = -1;  ///< points (2, 1) and (1, 2) beside the sharp edges
    int inner = 0;                        ///< per face: point (2, 2)
    int count = 0;
};

/// First of the four points of the half that `t` lies in, and the weights of the four.
std::pair<int, Eigen::Vector4d> half_bernstein(double t) {
    const int half = t < 0.5 ? 0 : 1;
    const double b = 2.0 * t - half, a = 1.0 - b;
    return {3 * half, {a * a * a, 3.0 * a * a * b, 3.0 * a * b * b, b * b * b}};
}

}  // namespace

struct CapSolver::Plan {
    FanKind kind;
    int n;
    double angle;
    Unknowns at;
    Sparse influence;    ///< points x unknowns
    Sparse energy;       ///< third derivatives x points
    Sparse bending;      ///< third derivatives x unknowns
    Sparse gram;         ///< of bending
    Cholesky smoothest;  ///< of gram

    Plan(FanKind fan_kind, int size, double corner_angle)
        : kind(fan_kind),
          n(size),
          angle(kind == FanKind::Corner   ? corner_angle
                : kind == FanKind::Crease ? M_PI / size
                                          : 2.0 * M_PI / size) {
        const auto next = [&] { return at.count++; };
        if (kind == FanKind::Ring || kind == FanKind::Dart) at.x = next();
        if (kind != FanKind::Corner) at.y = next();
        if (!is_ring() || n % 2 == 0) at.twist = next();
        if (kind == FanKind::Dart) at.dart = next();
        at.spread = is_ring() ? at.count : at.count - 1;  // edge 0 of others is sharp
        at.count += is_ring() ? n : n - 1;
        if (!is_ring()) {
            at.first_side = next();
            at.last_side = next();
        }
        at.inner = at.count;
        at.count += n;

        influence = influence_of_unknowns();
        energy = energy_rows();
        bending = energy * influence;
        gram = Sparse(bending.transpose()) * bending;
        smoothest.compute(gram);
    }

    /// Unknowns that belong to one face or edge act on the faces beside it only: many of them are
    /// tried at once. Source: Curtis, Powell, Reid, On the estimation of sparse Jacobian matrices
    /// (1974).
    [[nodiscard]] Sparse influence_of_unknowns() const {
        const int own = at.inner;  // where the unknowns begin that are one a face
        const auto is_spread = [&](int k) {
            return k >= first_spread() && k < first_spread() + spreads();
        };
        // Neighbouring edges have different colours, around odd rings too.
        const auto colour = [&](int edge) {
            return is_ring() && n % 2 == 1 && edge == n - 1 ? 2 : edge % 2;
        };
        std::vector<int> column(std::size_t(at.count));
        constexpr int colours = 4;  // of edges, and one of faces
        int columns = colours;
        for (int k = 0; k < at.count; ++k)
            column[std::size_t(k)] = k >= own       ? 3
                                     : is_spread(k) ? colour(k - at.spread)
                                                    : columns++;
        Matrix trial = Matrix::Zero(at.count, columns);
        for (int k = 0; k < at.count; ++k) trial(k, column[std::size_t(k)]) = 1.0;
        Matrix effect = Matrix::Zero(Eigen::Index(cap_points) * n, columns);
        fill(effect, trial);
        std::vector<Eigen::Triplet<double>> entries;
        const auto add = [&](int k, int face) {
            for (int row = cap_row(face, 0, 0); row < cap_row(face + 1, 0, 0); ++row) {
                const double value = effect(row, column[std::size_t(k)]);
                if (value != 0.0) entries.emplace_back(row, k, value);
            }
        };
        for (int k = 0; k < at.count; ++k) {
            if (k >= own) {
                add(k, k - own);
            } else if (is_spread(k)) {
                add(k, (k - at.spread) % n);
                add(k, (k - at.spread + n - 1) % n);
            } else {
                for (int face = 0; face < n; ++face) add(k, face);
            }
        }
        Sparse result(effect.rows(), at.count);
        result.setFromTriplets(entries.begin(), entries.end());
        return result;
    }
    [[nodiscard]] int spreads() const { return is_ring() ? n : n - 1; }
    [[nodiscard]] int first_spread() const { return is_ring() ? at.spread : at.spread + 1; }

    [[nodiscard]] bool is_ring() const { return kind == FanKind::Ring; }
    [[nodiscard]] bool is_smooth(int edge) const { return is_ring() || (edge > 0 && edge < n); }

    /// Completes the columns of `b` (points) for the given unknowns. Linear in both together.
    void fill(Matrix& b, const Matrix& unknown) const {
        const auto value = [&](int row) -> Row {
            return row < 0 ? Row(Row::Zero(b.cols())) : Row(unknown.row(row));
        };
        const auto point = [&](int face, int i, int j) { return b.row(cap_row(face, i, j)); };
        const Row vertex = point(0, 0, 0);
        const int edges = is_ring() ? n : n + 1;

        Row x = value(at.x), y = value(at.y);
        if (at.x < 0) x = 1.5 * (point(0, 1, 0) - vertex);
        if (kind == FanKind::Corner) {
            const Row last = 1.5 * (point(n - 1, 0, 1) - vertex);
            y = (last - std::cos(n * angle) * x) / std::sin(n * angle);
        }
        if (is_ring() && n % 2 == 0) remove_alternation(b);

        std::vector<Row> second(static_cast<std::size_t>(edges)), sum(second);
        for (int s = 0; s < edges; ++s) {
            const int right = s % n, left = (s + n - 1) % n;
            const Row tangent = std::cos(s * angle) * x + std::sin(s * angle) * y;
            Row first = vertex + 2.0 / 3.0 * tangent;
            Row& b20 = second[std::size_t(s)];
            if (is_smooth(s)) {
                const Row p1 = vertex + tangent;
                const Row p2 = (2.0 * p1 + 3.0 * point(right, 4, 0)) / 5.0;
                b20 = (2.0 * p1 + p2) / 3.0;
                sum[std::size_t(s)] = 2.0 * first + 4.0 / 9.0 * std::cos(angle) * (p2 - p1);
            } else if (kind == FanKind::Dart) {
                b20 = value(at.dart);
            } else {
                first = s == 0 ? point(0, 1, 0) : point(n - 1, 0, 1);
                b20 = s == 0 ? point(0, 2, 0) : point(n - 1, 0, 2);
            }
            if (is_ring() || s < n) {
                point(right, 0, 0) = vertex;
                point(right, 1, 0) = first;
                point(right, 2, 0) = b20;
            }
            if (is_ring() || s > 0) {
                point(left, 0, 1) = first;
                point(left, 0, 2) = b20;
            }
        }
        fill_twists(b, sum, value(at.twist));
        for (int s = 0; s < edges; ++s) {
            const int right = s % n, left = (s + n - 1) % n;
            if (is_smooth(s)) {
                const Row spread = value(at.spread + s);
                point(right, 2, 1) = second[std::size_t(s)] + spread;
                point(left, 1, 2) = second[std::size_t(s)] - spread;
            } else if (s == 0) {
                point(right, 2, 1) = value(at.first_side);
            } else {
                point(left, 1, 2) = value(at.last_side);
            }
        }
        fill_inner(b, unknown);
    }

    /// Points (2, 2), and those between the halves of each face, which meet with C1.
    void fill_inner(Matrix& b, const Matrix& unknown) const {
        const auto point = [&](int face, int i, int j) { return b.row(cap_row(face, i, j)); };
        for (int s = 0; s < n; ++s) {
            point(s, 2, 2) = unknown.row(at.inner + s);
            for (int k = 0; k < 3; ++k) {
                point(s, 3, k) = 0.5 * (point(s, 2, k) + point(s, 4, k));
                point(s, k, 3) = 0.5 * (point(s, k, 2) + point(s, k, 4));
            }
            point(s, 3, 3) = 0.5 * (point(s, 2, 3) + point(s, 4, 3));
        }
    }

    /// Points (1, 1): those beside a smooth edge have a known sum. Solvable in chains and odd
    /// rings; in even rings when the sums alternate to zero, see remove_alternation().
    void fill_twists(Matrix& b, const std::vector<Row>& sum, const Row& free) const {
        Row twist = free;
        if (is_ring() && n % 2 == 1) {
            twist.setZero();
            for (int k = 0; k < n; ++k) {
                twist += (k % 2 == 0 ? 0.5 : -0.5) * sum[std::size_t((n - k) % n)];
            }
        }
        for (int s = 0; s < n; ++s) {
            if (s > 0) twist = (sum[std::size_t(s)] - twist).eval();
            b.row(cap_row(s, 1, 1)) = twist;
        }
    }

    /// Moves the points (4, 0) of the edges, and those beside them, so that they alternate to zero.
    /// That gives up the second derivative at the outer border, no more.
    void remove_alternation(Matrix& b) const {
        Row alternation = Row::Zero(b.cols());
        for (int s = 0; s < n; ++s) {
            alternation += (s % 2 == 0 ? 1.0 : -1.0) / n * b.row(cap_row(s, 4, 0));
        }
        for (int s = 0; s < n; ++s) {
            const int left = (s + n - 1) % n;
            const Row shift = s % 2 == 0 ? Row(-alternation) : alternation;
            for (const int side : {0, 1}) {
                b.row(cap_row(s, 4, side)) += shift;
                b.row(cap_row(left, side, 4)) += shift;
            }
        }
    }

    /// Third derivatives within the pieces, up to a common factor, along the lines of points that
    /// have unknowns.
    [[nodiscard]] Sparse energy_rows() const {
        constexpr double third[4] = {-1, 3, -3, 1};
        constexpr double second[3] = {1, -2, 1};
        constexpr int lines = 4;  // the fifth one has no unknowns
        // Two derivatives one way and one the other come in three orders.
        const double mixed = std::sqrt(3.0);
        std::vector<Eigen::Triplet<double>> entries;
        int row = 0;
        for (int s = 0; s < n; ++s) {
            for (int line = 0; line < lines; ++line) {
                for (const bool along_i : {true, false}) {
                    const auto column = [&](int k, int l) {
                        return along_i ? cap_row(s, k, l) : cap_row(s, l, k);
                    };
                    for (const int half : {0, 3}) {
                        for (int k = 0; k < 4; ++k)
                            entries.emplace_back(row, column(half + k, line), third[k]);
                        ++row;
                        for (const int start : {half, half + 1}) {
                            for (int k = 0; k < 3; ++k) {
                                const double weight = mixed * second[k];
                                entries.emplace_back(row, column(start + k, line), -weight);
                                entries.emplace_back(row, column(start + k, line + 1), weight);
                            }
                            ++row;
                        }
                    }
                }
            }
        }
        Sparse rows(row, Eigen::Index(cap_points) * n);
        rows.setFromTriplets(entries.begin(), entries.end());
        return rows;
    }
};

CapSolver::CapSolver(FanKind kind, int size, double angle)
    : plan_(std::make_unique<const Plan>(kind, size, angle)) {}

CapSolver::~CapSolver() = default;

double CapSolver::angle() const { return plan_->angle; }

CapSolver::Net CapSolver::fit(const Net& points, const std::vector<Target>& targets,
                              double weight) const {
    const Plan& plan = *plan_;
    Matrix known = points;
    plan.fill(known, Matrix::Zero(plan.at.count, 3));
    // Three times the unknowns, as normals couple the coordinates.
    const int m = plan.at.count;
    const Eigen::SparseMatrix<double, Eigen::RowMajor> influence(plan.influence);
    std::vector<Eigen::Triplet<double>> distances;  // targets x unknowns
    Eigen::VectorXd distance(Eigen::Index(targets.size()));
    for (std::size_t k = 0; k < targets.size(); ++k) {
        const Target& target = targets[k];
        const auto [first_u, weights_u] = half_bernstein(target.u);
        const auto [first_v, weights_v] = half_bernstein(target.v);
        Eigen::RowVector3d of_known = Eigen::RowVector3d::Zero();
        for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 4; ++j) {
                const double w = weights_u[i] * weights_v[j];
                const int point = cap_row(target.face, first_u + i, first_v + j);
                of_known += w * known.row(point);
                for (decltype(influence)::InnerIterator e(influence, point); e; ++e)
                    for (int c = 0; c < 3; ++c)
                        distances.emplace_back(int(k), c * m + int(e.col()),
                                               target.normal[c] * w * e.value());
            }
        }
        distance[Eigen::Index(k)] = target.normal.dot(target.point - of_known);
    }
    Sparse rows(Eigen::Index(targets.size()), Eigen::Index(3) * m);
    rows.setFromTriplets(distances.begin(), distances.end());
    Eigen::VectorXd right = rows.transpose() * distance;
    const Matrix rest = plan.bending.transpose() * (plan.energy * known);
    std::vector<Eigen::Triplet<double>> bending;
    for (int c = 0; c < 3; ++c) {
        right.segment(Eigen::Index(c) * m, m) -= weight * weight * rest.col(c);
        for (int k = 0; k < m; ++k)
            for (Sparse::InnerIterator e(plan.gram, k); e; ++e)
                bending.emplace_back(c * m + int(e.row()), c * m + k, weight * weight * e.value());
    }
    Sparse normal_matrix(Eigen::Index(3) * m, Eigen::Index(3) * m);
    normal_matrix.setFromTriplets(bending.begin(), bending.end());
    normal_matrix += Sparse(rows.transpose()) * rows;
    const Eigen::VectorXd solution = Cholesky(normal_matrix).solve(right);
    Matrix unknown(m, 3);
    for (Eigen::Index c = 0; c < 3; ++c) unknown.col(c) = solution.segment(c * m, m);
    known = points;
    plan.fill(known, unknown);
    return known;
}

CapSolver::Net CapSolver::solve(const Net& points) const {
    Matrix known = points;
    plan_->fill(known, Matrix::Zero(plan_->at.count, 3));
    const Matrix unknown =
        -plan_->smoothest.solve(plan_->bending.transpose() * (plan_->energy * known));
    known = points;
    plan_->fill(known, unknown);
    return known;
}

}  // namespace patchwright::patch
