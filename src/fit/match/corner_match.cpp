#include "fit/match/corner_match.h"

#include "fit/match/assignment.h"

#include <patchwright/base/numbers.h>

#include <algorithm>

namespace patchwright::fit {

using base::infinity;
using geom::Features;
using geom::length_of;
using geom::point_along;
using geom::Points;
using geom::Vec3;
using mesh::VertexId;

namespace {

// Corners of the reference closer than this share of the reach are told apart by the directions of
// their curves (features_test: corners in one place).
constexpr double crowded_rel = 0.05;
// A corner reaches this share of its shortest chain, see FitOptions::feature_reach_rel.
constexpr double reach_of_chain = 0.25;

/// Mean squared distance between the first parts of chains, once moved with their end to a corner
/// of the reference, and the curves that end there.
double mean_squared_deviation(const std::vector<ChainEnd>& ends, const Vec3& at, int corner,
                              const geom::ReferenceSurface& reference) {
    constexpr double first_part = 0.3;
    constexpr int samples = 4;
    const Features& features = reference.features();
    const geom::FeatureCorner& there = features.corners[std::size_t(corner)];
    double sum = 0.0;
    for (const ChainEnd& end : ends) {
        for (int k = 1; k <= samples; ++k) {
            const Vec3 along = point_along(end.line, first_part * k / samples);
            const Vec3 moved = along - at + there.point;
            double nearest = (along - at).norm();
            for (const int curve : there.curves)
                if (features.curves[std::size_t(curve)].kind == end.kind)
                    nearest = std::min(nearest, reference.nearest_on_curve(curve, moved).distance);
            sum += nearest * nearest;
        }
    }
    return ends.empty() ? 0.0 : sum / double(samples * ends.size());
}

/// Which corners of the reference are so near to others, as on both sides of a slit, that distance
/// does not distinguish them.
std::vector<char> crowded_corners(const Features& features, double near) {
    std::vector<char> crowded(features.corners.size(), 0);
    for (std::size_t i = 0; i < crowded.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if ((features.corners[i].point - features.corners[j].point).norm() < near)
                crowded[i] = crowded[j] = 1;
    return crowded;
}

}  // namespace

std::map<VertexId, int> match_corners(const std::vector<VertexId>& vertices, const Points& points,
                                      const ChainEnds& chains,
                                      const geom::ReferenceSurface& reference, double reach,
                                      const std::function<void()>& poll) {
    const Features& features = reference.features();
    const std::vector<char> crowded = crowded_corners(features, crowded_rel * reach);
    Eigen::MatrixXd cost(Eigen::Index(vertices.size()), Eigen::Index(features.corners.size()));
    Eigen::VectorXd without(cost.rows());
    for (Eigen::Index i = 0; i < cost.rows(); ++i) {
        poll();
        const Vec3 at = points.row(vertices[std::size_t(i)].value).transpose();
        const auto here = chains.find(vertices[std::size_t(i)]);
        double far = reach;
        if (here != chains.end()) {
            double shortest = infinity;
            for (const ChainEnd& end : here->second)
                shortest = std::min(shortest, length_of(end.line));
            far = std::max(far, reach_of_chain * shortest);
        }
        without[i] = far * far;
        for (Eigen::Index j = 0; j < cost.cols(); ++j) {
            const double d = (features.corners[std::size_t(j)].point - at).norm();
            cost(i, j) = d <= far ? d * d : infinity;
            if (d <= far && crowded[std::size_t(j)] != 0 && here != chains.end())
                cost(i, j) += std::min(without[i],
                                       mean_squared_deviation(here->second, at, int(j), reference));
        }
    }
    // Any corner within reach costs less than none, and none less than one beyond.
    const double none = 2.0 * without.sum();
    const auto assigned =
        assign(cost.cwiseMin(4.0 * none), (without.array() + none).matrix(), poll);
    std::map<VertexId, int> result;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        if (assigned[i] >= 0) result[vertices[i]] = assigned[i];
    }
    return result;
}

}  // namespace patchwright::fit
