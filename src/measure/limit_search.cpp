#include "measure/limit_search.h"

#include "measure/limit_sites.h"

#include <patchwright/base/parallel.h>
#include <patchwright/geom/nearest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <span>

namespace patchwright::measure {

namespace {

using geom::Points;
using geom::Vec3;

/// Facets along a face's side.
constexpr int n = 4;
/// Gauss-Newton converges linearly where the surface bends; what is left after these steps is far
/// below what anybody asks for.
constexpr int steps = 4;

/// How far the limit surface may be from a facet, in parts of the facet's side: a tenth is an arc
/// of 45 degrees.
constexpr double bulge = 0.1;

/// See faces_alike(): 73 degrees.
constexpr double alike_cosine = 0.3;

/// Numbers within the grid of a site: i * (n + 1) + j.
using Facet = std::array<int, 3>;

std::array<Facet, std::size_t(2 * n * n)> facets_of_site() {
    std::array<Facet, std::size_t(2 * n * n)> facets{};
    std::size_t next = 0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const auto at = [&](int di, int dj) { return (i + di) * (n + 1) + j + dj; };
            facets[next++] = {at(0, 0), at(1, 0), at(1, 1)};
            facets[next++] = {at(0, 0), at(1, 1), at(0, 1)};
        }
    }
    return facets;
}

/// The nearest facets of a few sites, nearest first.
class NearestSites {
  public:
    void clear() { count_ = 0; }
    [[nodiscard]] std::span<const NearLimit> sites() const { return {kept_.data(), count_}; }

    void add(const NearLimit& one) {
        const auto end = kept_.begin() + std::ptrdiff_t(count_);
        auto place = std::find_if(kept_.begin(), end,
                                  [&](const NearLimit& k) { return k.site == one.site; });
        if (place != end && place->distance <= one.distance) return;
        if (place == end) {
            if (count_ < kept_.size()) {
                ++count_;
            } else if (!(one.distance < kept_.back().distance)) {
                return;
            } else {
                --place;
            }
        }
        for (; place != kept_.begin() && std::prev(place)->distance > one.distance; --place)
            *place = *std::prev(place);
        *place = one;
    }

  private:
    std::array<NearLimit, 4> kept_;
    std::size_t count_ = 0;
};

}  // namespace

bool faces_alike(const Vec3& normal, const Vec3& direction) {
    return normal.dot(direction) > alike_cosine * normal.norm() * direction.norm();
}

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
    best.normal = at.normal;
    best.distance = (query - at.position).norm();
    for (int step = 0; step < steps && at.smoothness == subd::Smoothness::Derivatives; ++step) {
        const Vec3 way = query - at.position;
        const double a = at.du.squaredNorm(), b = at.du.dot(at.dv), c = at.dv.squaredNorm();
        const double determinant = a * c - b * b;
        if (!(determinant > 1e-12 * a * c)) break;
        const double along_u = at.du.dot(way), along_v = at.dv.dot(way);
        double u = best.u + (c * along_u - b * along_v) / determinant;
        double v = best.v + (a * along_v - b * along_u) / determinant;
        if (u < 0.0 || u > 1.0) {  // along the face's side
            u = std::clamp(u, 0.0, 1.0);
            v = best.v + (along_v - b * (u - best.u)) / c;
        } else if (v < 0.0 || v > 1.0) {
            v = std::clamp(v, 0.0, 1.0);
            u = best.u + (along_u - b * (v - best.v)) / a;
        }
        u = std::clamp(u, 0.0, 1.0);
        v = std::clamp(v, 0.0, 1.0);
        at = evaluate(u, v);
        const double distance = (query - at.position).norm();
        if (!(distance < best.distance)) break;
        best = {best.site, u, v, at.position, at.normal, distance};
    }
    return best;
}

namespace {

/// The limit surface as flat facets: n x n squares a site, halved.
class FacetTree {
  public:
    FacetTree(const subd::LimitOperator& grid, const Points& control_points)
        : rows_(grid.site_rows()) {
        grid.apply(control_points, points_);
        std::vector<geom::Box3> boxes((rows_.size() - 1) * facets_.size());
        for (std::size_t t = 0; t < boxes.size(); ++t) {
            for (const Vec3& p : corners(int(t))) boxes[t].add(p);
        }
        tree_ = geom::Bvh(boxes);
    }

    void find(const Vec3& query, const Vec3* facing, NearestSites& near) const {
        near.clear();
        tree_.nearest(query, std::numeric_limits<double>::infinity(), [&](int t, double bound) {
            const auto corner = corners(t);
            if (facing != nullptr &&
                !faces_alike((corner[1] - corner[0]).cross(corner[2] - corner[0]), *facing))
                return bound;
            const Vec3 w = geom::nearest_weights(query, corner);
            const Vec3 point = w[0] * corner[0] + w[1] * corner[1] + w[2] * corner[2];
            const double distance = (point - query).norm();
            if (!(distance < bound)) return bound;
            const double side =
                std::max((corner[1] - corner[0]).norm(), (corner[2] - corner[0]).norm());
            const auto& facet = facets_[std::size_t(t) % facets_.size()];
            NearLimit start{.site = t / int(facets_.size()), .distance = distance};
            for (std::size_t k = 0; k < 3; ++k) {
                start.u += w[Eigen::Index(k)] * (facet[k] / (n + 1)) / n;
                start.v += w[Eigen::Index(k)] * (facet[k] % (n + 1)) / n;
            }
            start.u = std::min(start.u, 1.0);  // weights may add up to a little more than 1
            start.v = std::min(start.v, 1.0);
            near.add(start);
            return std::min(bound, distance + bulge * side);
        });
    }

  private:
    [[nodiscard]] std::array<Vec3, 3> corners(int number) const {
        const std::size_t site = std::size_t(number) / facets_.size();
        std::array<Vec3, 3> result;
        for (std::size_t k = 0; k < 3; ++k) {
            result[k] = points_.row(rows_[site] + facets_[std::size_t(number) % facets_.size()][k])
                            .transpose();
        }
        return result;
    }

    const std::vector<std::int32_t>& rows_;
    const std::array<Facet, std::size_t(2 * n * n)> facets_ = facets_of_site();
    Points points_;
    geom::Bvh tree_;
};

}  // namespace

std::vector<NearLimit> LimitSearch::nearest(const Points& control_points,
                                            const std::vector<Vec3>& queries,
                                            const std::vector<Vec3>& facing,
                                            const base::Progress& progress) const {
    const FacetTree facets(grid_, control_points);
    std::vector<NearLimit> result(queries.size());
    constexpr std::size_t block = 8192, grain = 64;
    for (std::size_t start = 0; start < queries.size(); start += block) {
        base::report_progress(progress, "coverage", double(start) / double(queries.size()));
        const std::size_t count = std::min(block, queries.size() - start);
        base::parallel_for(count, grain, [&](std::size_t first, std::size_t last) {
            NearestSites near;
            for (std::size_t q = start + first; q < start + last; ++q) {
                const Vec3* toward = facing.empty() ? nullptr : &facing[q];
                facets.find(queries[q], toward, near);
                result[q].distance = std::numeric_limits<double>::infinity();
                for (const NearLimit& at : near.sites()) {
                    const NearLimit found = improved(control_points, at, queries[q]);
                    if (found.distance < result[q].distance) result[q] = found;
                }
            }
        });
    }
    return result;
}

}  // namespace patchwright::measure
