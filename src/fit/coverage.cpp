#include "fit/coverage.h"

#include "fit/sampling.h"

#include <patchwright/base/parallel.h>
#include <patchwright/geom/nearest.h>

#include <algorithm>
#include <array>
#include <limits>

namespace patchwright::fit {

namespace {

using geom::Points;
using geom::Vec3;

/// Facets along a face's side.
constexpr int n = 4;
/// Gauss-Newton converges linearly where the surface bends; what is left after these steps is far
/// below what anybody asks for.
constexpr int steps = 4;

struct Facet {
    std::array<int, 3> corner;  ///< numbers within the grid of a site: i * (n + 1) + j
};

std::array<Facet, std::size_t(2 * n * n)> facets_of_site() {
    std::array<Facet, std::size_t(2 * n * n)> facets{};
    std::size_t next = 0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const auto at = [&](int di, int dj) { return (i + di) * (n + 1) + j + dj; };
            facets[next++] = {{at(0, 0), at(1, 0), at(1, 1)}};
            facets[next++] = {{at(0, 0), at(1, 1), at(0, 1)}};
        }
    }
    return facets;
}

}  // namespace

LimitSearch::LimitSearch(std::shared_ptr<const mesh::Topology> topology)
    : sites_(face_sites(*topology)),
      grid_(*topology, {closed_grid(n)}, sites_),
      evaluator_(std::move(topology)) {}

NearLimit LimitSearch::improved(const Points& control_points, NearLimit best,
                                const Vec3& query) const {
    const subd::Site& site = sites_[std::size_t(best.site)];
    const auto evaluate = [&](double u, double v) {
        return evaluator_.evaluate(control_points, {site.face, u, v, site.sector}, 1);
    };
    subd::LimitPoint at = evaluate(best.u, best.v);
    best.point = at.position;
    best.distance = (query - at.position).norm();
    for (int step = 0; step < steps && at.smoothness == subd::Smoothness::Derivatives; ++step) {
        const Vec3 way = query - at.position;
        const double a = at.du.squaredNorm(), b = at.du.dot(at.dv), c = at.dv.squaredNorm();
        const double determinant = a * c - b * b;
        if (!(determinant > 1e-12 * a * c)) break;
        const double along_u = at.du.dot(way), along_v = at.dv.dot(way);
        const double u =
            std::clamp(best.u + (c * along_u - b * along_v) / determinant, 0.0, 1.0);
        const double v =
            std::clamp(best.v + (a * along_v - b * along_u) / determinant, 0.0, 1.0);
        at = evaluate(u, v);
        const double distance = (query - at.position).norm();
        if (!(distance < best.distance)) break;
        best = {best.site, u, v, at.position, distance};
    }
    return best;
}

std::vector<NearLimit> LimitSearch::nearest(const Points& control_points,
                                            const std::vector<Vec3>& queries) const {
    static const auto facets = facets_of_site();
    Points grid;
    grid_.apply(control_points, grid);
    const auto corners = [&](int number) {
        const std::size_t site = std::size_t(number) / facets.size();
        std::array<Vec3, 3> result;
        for (std::size_t k = 0; k < 3; ++k) {
            result[k] = grid.row(grid_.site_rows()[site] +
                                 facets[std::size_t(number) % facets.size()].corner[k])
                            .transpose();
        }
        return result;
    };
    std::vector<geom::Box3> boxes(sites_.size() * facets.size());
    for (std::size_t t = 0; t < boxes.size(); ++t) {
        for (const Vec3& p : corners(int(t))) boxes[t].add(p);
    }
    const geom::Bvh tree(boxes);
    std::vector<NearLimit> result(queries.size());
    base::parallel_for(queries.size(), 64, [&](std::size_t first, std::size_t last) {
        for (std::size_t q = first; q < last; ++q) {
            int nearest = -1;
            Vec3 weights;
            tree.nearest(queries[q], std::numeric_limits<double>::infinity(),
                         [&](int t, double bound) {
                             const auto corner = corners(t);
                             const Vec3 w = geom::nearest_weights(queries[q], corner);
                             const double distance =
                                 (w[0] * corner[0] + w[1] * corner[1] + w[2] * corner[2] -
                                  queries[q])
                                     .norm();
                             if (!(distance < bound)) return bound;
                             nearest = t;
                             weights = w;
                             return distance;
                         });
            NearLimit start{.site = nearest / int(facets.size())};
            const Facet& facet = facets[std::size_t(nearest) % facets.size()];
            for (std::size_t k = 0; k < 3; ++k) {
                const double share = weights[Eigen::Index(k)] / n;
                start.u += share * (facet.corner[k] / (n + 1));
                start.v += share * (facet.corner[k] % (n + 1));
            }
            result[q] = improved(control_points, start, queries[q]);
        }
    });
    return result;
}

}  // namespace patchwright::fit
