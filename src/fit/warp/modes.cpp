#include "fit/loop/sampling.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/modes.h>
#include <patchwright/subd/limit_operator.h>

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::fit {

namespace {

using geom::Points;

/// Of the largest variance: what rounding leaves of modes that are not there.
constexpr double rounding = 1e-13;

/// Gauss-Legendre rule of four points on [0, 1]: exact for products of two cubics.
constexpr std::array<double, 4> nodes{0.069431844202973713, 0.33000947820757187,
                                      0.66999052179242813, 0.93056815579702629};
constexpr std::array<double, 4> node_weights{0.17392742256872693, 0.32607257743127307,
                                             0.32607257743127307, 0.17392742256872693};

/// The mean of a product of displacements over the limit surface of a cage.
class SurfaceProduct {
  public:
    SurfaceProduct(const mesh::Topology& topology, const Points& points)
        : limit_(topology, {places()}, face_sites(topology), subd::SampleRows::PointsAndTangents),
          weights_(limit_.normals(points).rowwise().norm()) {
        for (Eigen::Index i = 0; i < weights_.size(); ++i)
            weights_[i] *= node_weights[std::size_t(i % 16) / 4] * node_weights[std::size_t(i % 4)];
        weights_ /= weights_.sum();
    }

    /// b with <a, displacement> = sum of products of a's and b's entries.
    [[nodiscard]] Points operator()(const Points& displacement) const {
        Points samples, result;
        limit_.apply(displacement, samples);
        samples.array().colwise() *= weights_.array();
        limit_.apply_transposed(samples, result);
        return result;
    }

  private:
    static subd::ParameterSet places() {
        subd::ParameterSet set;
        for (const double u : nodes)
            for (const double v : nodes) set.emplace_back(u, v);
        return set;
    }

    subd::LimitOperator limit_;
    Eigen::VectorXd weights_;
};

double product(const Points& a, const Points& b) { return (a.array() * b.array()).sum(); }

void check(const mesh::Topology& topology, const std::vector<Points>& members, int count) {
    if (members.size() < 2)
        throw base::InvalidArgument(
            fmt::format("{} members have no modes; two are needed", members.size()));
    if (count < 1) throw base::InvalidArgument(fmt::format("{} modes are asked for", count));
    for (std::size_t i = 0; i < members.size(); ++i)
        if (members[i].rows() != topology.vertex_count())
            throw base::InvalidArgument(fmt::format("member {} has {} control points, the mesh {}",
                                                    i + 1, members[i].rows(),
                                                    topology.vertex_count()));
}

}  // namespace

double Modes::share(int modes) const {
    if (variance_mm2 <= 0.0) return 1.0;
    double sum = 0.0;
    for (std::size_t k = 0; k < deviations_mm.size() && k < std::size_t(modes); ++k)
        sum += deviations_mm[k] * deviations_mm[k];
    return std::min(1.0, sum / variance_mm2);
}

Points member(const Modes& modes, const Eigen::VectorXd& weights) {
    if (weights.size() != modes.count())
        throw base::InvalidArgument(
            fmt::format("{} weights for {} modes", weights.size(), modes.count()));
    Points points = modes.mean;
    for (std::size_t k = 0; k < modes.shapes.size(); ++k)
        points += weights[Eigen::Index(k)] * modes.shapes[k];
    return points;
}

Modes principal_modes(const std::shared_ptr<const mesh::Topology>& topology,
                      const std::vector<Points>& members, int count) {
    check(*topology, members, count);
    const auto n = Eigen::Index(members.size());
    Modes modes{.mean = Points::Zero(topology->vertex_count(), 3),
                .weights = Eigen::MatrixXd(n, 0)};
    for (const Points& points : members) modes.mean += points / double(n);
    const SurfaceProduct on_surface(*topology, modes.mean);
    std::vector<Points> displacements;
    for (const Points& points : members) displacements.push_back(points - modes.mean);
    Eigen::MatrixXd products(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const Points weighed = on_surface(displacements[std::size_t(i)]);
        for (Eigen::Index j = 0; j <= i; ++j)
            products(i, j) = products(j, i) = product(weighed, displacements[std::size_t(j)]);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(products);
    modes.variance_mm2 = products.trace() / double(n);
    // Members that are equal differ by the rounding of their mean.
    const double size = 1e-15 * modes.mean.norm();
    const double least = std::max(rounding * eigen.eigenvalues()[n - 1], size * size);
    for (Eigen::Index k = n - 1; k >= 0 && modes.count() < count; --k) {
        const double square = eigen.eigenvalues()[k];
        if (!(square > least)) break;
        Eigen::VectorXd shares = eigen.eigenvectors().col(k);
        Eigen::Index farthest = 0;
        shares.cwiseAbs().maxCoeff(&farthest);
        if (shares[farthest] < 0.0) shares = -shares;
        Points shape = Points::Zero(modes.mean.rows(), 3);
        for (Eigen::Index i = 0; i < n; ++i)
            shape += shares[i] / std::sqrt(square) * displacements[std::size_t(i)];
        modes.shapes.push_back(std::move(shape));
        modes.deviations_mm.push_back(std::sqrt(square / double(n)));
        modes.weights.conservativeResize(n, modes.count());
        modes.weights.col(modes.count() - 1) = std::sqrt(square) * shares;
    }
    if (modes.count() == 0) modes.variance_mm2 = 0.0;
    return modes;
}

}  // namespace patchwright::fit
