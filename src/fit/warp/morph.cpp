#include <patchwright/base/error.h>
#include <patchwright/base/numbers.h>
#include <patchwright/base/parallel.h>
#include <patchwright/fit/morph.h>

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace patchwright::fit {

namespace {

using base::at;
using Eigen::Index;
using Eigen::MatrixXd;
using geom::Points;
using geom::Vec3;

/// Distance, by half the points' diagonal, within which two of them are one place: their values
/// differ by less than rounding of what these are interpolated by.
constexpr double one_place_rel = 1e-9;
/// Extent of points across a plane, by the largest one, within which they are in it: rotations
/// about the plane's lines would lose more digits than this.
constexpr double in_plane_rel = 1e-6;
constexpr std::size_t grain = 16;  ///< rows of thousands of distances each

/// Where distances are of the size of 1.
struct Frame {
    explicit Frame(const geom::Box3& box) : centre(box.centre()), scale(0.5 * box.diagonal()) {}
    [[nodiscard]] Points local(const Points& points) const {
        return (points.rowwise() - centre.transpose()) / scale;
    }
    Vec3 centre;
    double scale;
};

/// The minus makes it positive definite on what no linear polynomial sees.
double kernel(const Points& a, Index i, const Points& b, Index j) {
    return -(a.row(i) - b.row(j)).norm();
}

/// 1, x, y, z.
MatrixXd linear(const Points& points) {
    MatrixXd values(points.rows(), 4);
    values << Eigen::VectorXd::Ones(points.rows()), points;
    return values;
}

/// Sum over j of kernel(to_i, from_j) times values_j, for each i.
Points kernel_sums(const Points& to, const Points& from, const Points& values) {
    Points sums(to.rows(), 3);
    base::parallel_for(std::size_t(to.rows()), grain, [&](std::size_t begin, std::size_t end) {
        for (Index i = Index(begin); i < Index(end); ++i) {
            Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
            for (Index j = 0; j < from.rows(); ++j) sum += kernel(to, i, from, j) * values.row(j);
            sums.row(i) = sum;
        }
    });
    return sums;
}

std::string name_of(const PointTransfer::Name& name, int point) {
    return name ? name(point) : fmt::format("point {}", point + 1);
}

/// The kernel between all points.
MatrixXd kernel_matrix(const Points& points, const PointTransfer::Name& name) {
    const Index n = points.rows();
    MatrixXd matrix(n, n);
    std::vector<Index> same(at(int(n)), -1);
    base::parallel_for(std::size_t(n), grain, [&](std::size_t begin, std::size_t end) {
        for (Index j = Index(begin); j < Index(end); ++j)
            for (Index i = 0; i < n; ++i) {
                matrix(i, j) = kernel(points, i, points, j);
                if (i < j && matrix(i, j) > -one_place_rel && same[at(int(j))] < 0)
                    same[at(int(j))] = i;
            }
    });
    const auto found = std::find_if(same.begin(), same.end(), [](Index i) { return i >= 0; });
    if (found == same.end()) return matrix;
    throw base::InputError(fmt::format("{} and {} are in one place; keep one of them",
                                       name_of(name, int(*found)),
                                       name_of(name, int(found - same.begin()))));
}

void check_count(Index count) {
    if (count > max_transfer_points)
        throw base::InputError(fmt::format(
            "{} points: a transfer starts from {} at most, whose matrix takes {:.1f} GB; leave "
            "points out",
            count, max_transfer_points, 8e-9 * max_transfer_points * max_transfer_points));
    if (count < 4)
        throw base::InputError(
            fmt::format("{} points: at least four are needed, not in one plane", count));
}

/// @param r  triangular factor of linear() of the points
void check_extents(const Eigen::Matrix4d& r, double scale, Index count) {
    // Below its first row it is that of the points from their mean.
    const Eigen::Matrix3d triangle = r.block<3, 3>(1, 1).triangularView<Eigen::Upper>();
    const Vec3 extents = triangle.jacobiSvd().singularValues();
    if (extents[2] > in_plane_rel * extents[0]) return;
    const bool is_line = extents[1] <= in_plane_rel * extents[0];
    throw base::InputError(fmt::format(
        "all points are in one {}, within {:.2g} mm: how far what is beside it turns is not known; "
        "add points off the {}, such as ends of rigid arms",
        is_line ? "line" : "plane", scale * extents[is_line ? 1 : 2] / std::sqrt(double(count)),
        is_line ? "line" : "plane"));
}

}  // namespace

/// With linear(from) = Q [R; 0], in the basis Q: the kernel between the structural points. Its
/// first rows are kept, the rest, which is positive definite, is replaced by its Cholesky factor.
struct PointTransfer::Factors {
    Points from, to;  // in the frame
    Eigen::HouseholderQR<MatrixXd> qr;
    MatrixXd kernel;
    double extrapolation = 0.0;

    Eigen::Matrix4d r;  ///< upper triangle
    [[nodiscard]] auto cross() const { return kernel.topRightCorner(4, kernel.cols() - 4); }
    /// Solves with the positive definite part.
    void solve(MatrixXd& values) const {
        const Index n = kernel.cols() - 4;
        const auto lower = kernel.bottomRightCorner(n, n).triangularView<Eigen::Lower>();
        lower.solveInPlace(values);
        lower.adjoint().solveInPlace(values);
    }
};

PointTransfer::PointTransfer(const Points& from, const Points& to, const Name& name) {
    check_count(from.rows());
    const geom::Box3 box = geom::bounding_box(from);
    if (!(box.diagonal() > 0.0)) throw base::InputError("all points are in one place");
    const Frame frame(box);
    const auto factors = std::make_shared<Factors>();
    factors->from = frame.local(from);
    factors->to = frame.local(to);
    factors->qr.compute(linear(factors->from));
    factors->r = factors->qr.matrixQR().topRows<4>();
    check_extents(factors->r, frame.scale, from.rows());
    MatrixXd& matrix = factors->kernel = kernel_matrix(factors->from, name);
    matrix.applyOnTheLeft(factors->qr.householderQ().adjoint());
    matrix.applyOnTheRight(factors->qr.householderQ());
    Eigen::Ref<MatrixXd> definite = matrix.bottomRightCorner(from.rows() - 4, from.rows() - 4);
    const Eigen::LLT<Eigen::Ref<MatrixXd>> llt(definite);  // in place
    if (llt.info() != Eigen::Success)
        throw base::InputError("points are too near each other to be told apart; leave some out");
    const MatrixXd weights = factors->r.transpose().triangularView<Eigen::Lower>().solve(
        linear(factors->to).transpose().eval());
    if (to.rows() > 0)
        factors->extrapolation = weights.colwise().norm().maxCoeff() * std::sqrt(from.rows());
    factors_ = factors;
}

int PointTransfer::rows() const { return int(factors_->to.rows()); }
int PointTransfer::columns() const { return int(factors_->from.rows()); }
double PointTransfer::extrapolation() const { return factors_->extrapolation; }

Points PointTransfer::apply(const Points& values) const {
    const Factors& f = *factors_;
    if (values.rows() != columns())
        throw base::InvalidArgument(
            fmt::format("{} values for {} structural points", values.rows(), columns()));
    const MatrixXd turned = f.qr.householderQ().adjoint() * MatrixXd(values);
    MatrixXd inner = turned.bottomRows(columns() - 4);
    f.solve(inner);
    const MatrixXd polynomial =
        f.r.triangularView<Eigen::Upper>().solve(turned.topRows(4) - f.cross() * inner);
    MatrixXd weights = MatrixXd::Zero(columns(), 3);
    weights.bottomRows(columns() - 4) = inner;
    weights.applyOnTheLeft(f.qr.householderQ());
    return kernel_sums(f.to, f.from, weights) + linear(f.to) * polynomial;
}

Points PointTransfer::apply_transposed(const Points& values) const {
    const Factors& f = *factors_;
    if (values.rows() != rows())
        throw base::InvalidArgument(fmt::format("{} values for {} points", values.rows(), rows()));
    const MatrixXd sums = kernel_sums(f.from, f.to, values);
    const MatrixXd turned = f.qr.householderQ().adjoint() * sums;
    MatrixXd result(columns(), 3);
    result.topRows(4) =
        f.r.transpose().triangularView<Eigen::Lower>().solve(linear(f.to).transpose() * values);
    MatrixXd inner = turned.bottomRows(columns() - 4) - f.cross().transpose() * result.topRows(4);
    f.solve(inner);
    result.bottomRows(columns() - 4) = inner;
    result.applyOnTheLeft(f.qr.householderQ());
    return result;
}

mesh::Cage morph(const mesh::Cage& cage, const PointTransfer& transfer,
                 const Points& displacements) {
    for (const mesh::SectorTagInput& sector : cage.topology->sectors())
        if (!Vec3(sector.normal.data()).isZero(0.0))
            throw base::InputError(fmt::format(
                "sector at vertex {}: its prescribed normal would not turn with the cage; take the "
                "normal out of the tag",
                sector.vertex));
    if (transfer.rows() != cage.points.rows())
        throw base::InvalidArgument("the transfer goes to other points than the cage's");
    mesh::Cage moved = cage;
    moved.points += transfer.apply(displacements);
    return moved;
}

Points control_point_forces(const std::shared_ptr<const mesh::Topology>& topology,
                            const subd::Locations& places, const Points& forces) {
    if (!topology->sectors().empty())
        throw base::InputError(
            fmt::format("sector at vertex {}: points beside tagged sectors are moved before the "
                        "limit is taken, so that forces cannot be carried to the control points; "
                        "take the tag out",
                        topology->sectors().front().vertex));
    if (forces.rows() != Index(places.size()))
        throw base::InvalidArgument(
            fmt::format("{} forces for {} places", forces.rows(), places.size()));
    return subd::LimitEvaluator(topology).masks(places).transposed().apply(forces);
}

Resultant resultant(const Points& points, const Points& forces, const Vec3& centre) {
    Resultant sum;
    for (Index i = 0; i < points.rows(); ++i) {
        const Vec3 force = forces.row(i), arm = points.row(i).transpose() - centre;
        sum.force += force;
        sum.moment += arm.cross(force);
    }
    return sum;
}

}  // namespace patchwright::fit
