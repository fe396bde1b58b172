#include "fit/match/corner_match.h"

#include "fit/match/assignment.h"

#include <algorithm>
#include <limits>

namespace patchwright::fit {

using geom::Features;
using geom::Points;
using geom::Vec3;
using mesh::VertexId;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// How far chains that are moved with their end to a corner of the reference go astray from the
/// curves that end there: mean square over their first parts.
double straying(const std::vector<ChainEnd>& ends, const Vec3& at, int corner,
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
/// does not tell them apart.
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
                                      const geom::ReferenceSurface& reference, double reach) {
    constexpr double near_in_reaches = 0.05;
    const Features& features = reference.features();
    const std::vector<char> crowded = crowded_corners(features, near_in_reaches * reach);
    Eigen::MatrixXd cost(Eigen::Index(vertices.size()), Eigen::Index(features.corners.size()));
    Eigen::VectorXd without(cost.rows());
    for (Eigen::Index i = 0; i < cost.rows(); ++i) {
        const Vec3 at = points.row(vertices[std::size_t(i)].value).transpose();
        const auto here = chains.find(vertices[std::size_t(i)]);
        double far = reach;
        if (here != chains.end()) {
            double shortest = infinity;
            for (const ChainEnd& end : here->second)
                shortest = std::min(shortest, length_of(end.line));
            far = std::max(far, 0.25 * shortest);
        }
        without[i] = far * far;
        for (Eigen::Index j = 0; j < cost.cols(); ++j) {
            const double d = (features.corners[std::size_t(j)].point - at).norm();
            cost(i, j) = d <= far ? d * d : infinity;
            if (d <= far && crowded[std::size_t(j)] != 0 && here != chains.end())
                cost(i, j) += std::min(without[i], straying(here->second, at, int(j), reference));
        }
    }
    // Rather a corner at the end of its reach than none; none is better than one beyond.
    const double dear = 2.0 * without.sum();
    const auto assigned = assign(cost.cwiseMin(4.0 * dear), (without.array() + dear).matrix());
    std::map<VertexId, int> result;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        if (assigned[i] >= 0) result[vertices[i]] = assigned[i];
    }
    return result;
}

}  // namespace patchwright::fit
