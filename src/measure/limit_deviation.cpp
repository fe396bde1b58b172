#include "measure/limit_deviation.h"

#include "measure/limit_search.h"
#include "measure/limit_sites.h"

#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_operator.h>

#include <algorithm>

namespace patchwright::measure {

namespace {

void measure_surface(const mesh::Cage& cage, const geom::ReferenceSurface& reference, int n,
                     LimitDeviation& error) {
    const auto sites = face_sites(*cage.topology);
    const subd::LimitOperator limit_operator(*cage.topology, {closed_grid(n)}, sites);
    struct SiteError {
        Distances surface;
        double change_u = 0.0, change_v = 0.0;
    };
    std::vector<SiteError> of_site(sites.size());
    limit_operator.visit_sites(
        cage.points, [&](std::size_t begin, std::size_t end, auto offset, auto) {
            const geom::Points limit = offset;
            // From limit points to their foot points.
            base::parallel_for(
                std::size_t(offset.rows()), 64, [&](std::size_t first, std::size_t last) {
                    for (auto i = Eigen::Index(first); i < Eigen::Index(last); ++i) {
                        const auto foot = reference.foot_point(offset.row(i).transpose());
                        offset.row(i) = foot.point.transpose() - offset.row(i);
                    }
                });
            for (std::size_t s = begin; s < end; ++s) {
                SiteError& site = of_site[s];
                const Eigen::Index first = Eigen::Index(s - begin) * (n + 1) * (n + 1);
                const auto at = [&](int i, int j) { return offset.row(first + i * (n + 1) + j); };
                for (int i = 0; i <= n; ++i) {
                    for (int j = 0; j <= n; ++j) {
                        site.surface.add(at(i, j).norm(),
                                         limit.row(first + i * (n + 1) + j).transpose());
                        if (i < n) site.change_u += (at(i + 1, j) - at(i, j)).squaredNorm();
                        if (j < n) site.change_v += (at(i, j + 1) - at(i, j)).squaredNorm();
                    }
                }
            }
        });
    for (std::size_t s = 0; s < sites.size(); ++s) {
        const SiteError& site = of_site[s];
        FaceDeviation& face = error.faces[sites[s].face.index()];
        error.surface.add(site.surface);
        face.max = std::max(face.max, site.surface.max);
        face.change_u += site.change_u;
        face.change_v += site.change_v;
    }
}

void measure_reverse(const mesh::Cage& cage, const std::vector<geom::Vec3>& points,
                     const LimitDeviationOptions& options, LimitDeviation& error) {
    if (points.empty()) return;
    const auto sites = face_sites(*cage.topology);
    const auto all = LimitSearch(cage.topology).nearest(cage.points, points, {}, options.progress);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const NearLimit& near = all[i];
        error.reverse.add(near.distance, points[i]);
        FaceDeviation& face = error.faces[sites[std::size_t(near.site)].face.index()];
        if (near.distance > options.far_mm) {
            face.beyond.extend(Eigen::Vector2d(near.u, near.v));
            ++face.beyond_count;
        }
        if (near.distance <= face.reverse) continue;
        face.reverse = near.distance;
        face.reverse_at = {near.u, near.v};
    }
}

}  // namespace

LimitDeviation measure_limit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                             const std::vector<geom::Vec3>& points,
                             const LimitDeviationOptions& options) {
    LimitDeviation result;
    result.faces.resize(std::size_t(cage.topology->face_count()));
    base::report_progress(options.progress, "measure", 0.0);
    measure_surface(cage, reference, options.intervals, result);
    measure_reverse(cage, points, options, result);
    base::report_progress(options.progress, "measure", 1.0);
    return result;
}

}  // namespace patchwright::measure
