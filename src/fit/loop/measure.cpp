#include "fit/loop/measure.h"

#include "fit/loop/coverage.h"
#include "fit/loop/sampling.h"

#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_operator.h>

#include <algorithm>

namespace patchwright::fit {

namespace {

using geom::Points;

void measure_surface(const mesh::Cage& cage, const geom::ReferenceSurface& reference, int n,
                     LevelError& error) {
    const auto sites = face_sites(*cage.topology);
    const subd::LimitOperator limit_operator(*cage.topology, {closed_grid(n)}, sites);
    struct SiteError {
        Distances surface;
        double change_u = 0.0, change_v = 0.0;
    };
    std::vector<SiteError> of_site(sites.size());
    limit_operator.visit_sites(
        cage.points, [&](std::size_t begin, std::size_t end, auto offset, auto) {
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
                        site.surface.add(at(i, j).norm());
                        if (i < n) site.change_u += (at(i + 1, j) - at(i, j)).squaredNorm();
                        if (j < n) site.change_v += (at(i, j + 1) - at(i, j)).squaredNorm();
                    }
                }
            }
        });
    for (std::size_t s = 0; s < sites.size(); ++s) {
        const SiteError& site = of_site[s];
        FaceError& face = error.faces[sites[s].face.index()];
        error.surface.add(site.surface);
        face.max = std::max(face.max, site.surface.max);
        face.change_u += site.change_u;
        face.change_v += site.change_v;
    }
}

void measure_curves(const mesh::Cage& cage, const LevelFit& fitted,
                    const geom::ReferenceSurface& reference, int n, LevelError& error) {
    const auto& sites = fitted.curves.sites;
    const subd::LimitOperator limit_operator(*cage.topology, side_sets(n), sites);
    Points limit;
    limit_operator.apply(cage.points, limit);
    std::vector<double> distance(std::size_t(limit.rows()), 0.0);
    base::parallel_for(sites.size(), 16, [&](std::size_t first, std::size_t last) {
        for (std::size_t s = first; s < last; ++s) {
            const FeaturePath& path =
                fitted.match.paths[std::size_t(fitted.curves.chain_of_site[s])];
            if (path.empty()) continue;
            for (auto i = std::size_t(limit_operator.site_rows()[s]);
                 i < std::size_t(limit_operator.site_rows()[s + 1]); ++i) {
                distance[i] =
                    nearest_on_path(reference, path, limit.row(Eigen::Index(i)).transpose())
                        .distance;
            }
        }
    });
    for (std::size_t s = 0; s < sites.size(); ++s) {
        FaceError& face = error.faces[sites[s].face.index()];
        double& side = sites[s].set % 2 == 0 ? face.curve_u : face.curve_v;
        for (auto i = std::size_t(limit_operator.site_rows()[s]);
             i < std::size_t(limit_operator.site_rows()[s + 1]); ++i) {
            error.curves.add(distance[i]);
            side = std::max(side, distance[i]);
        }
    }
}

void measure_reverse(const mesh::Cage& cage, const std::vector<geom::Vec3>& points,
                     double tolerance, LevelError& error) {
    if (points.empty()) return;
    const auto sites = face_sites(*cage.topology);
    for (const NearLimit& near : LimitSearch(cage.topology).nearest(cage.points, points)) {
        error.reverse.add(near.distance);
        FaceError& face = error.faces[sites[std::size_t(near.site)].face.index()];
        if (near.distance > tolerance) {
            face.beyond.extend(Eigen::Vector2d(near.u, near.v));
            ++face.beyond_count;
        }
        if (near.distance <= face.reverse) continue;
        face.reverse = near.distance;
        face.reverse_at = {near.u, near.v};
    }
}

}  // namespace

LevelError measure(const mesh::Cage& cage, const LevelFit& fitted,
                   const geom::ReferenceSurface& reference, const std::vector<geom::Vec3>& points,
                   const FitOptions& options) {
    const int samples_per_edge = options.solver.samples_per_edge;
    LevelError error;
    error.faces.resize(std::size_t(cage.topology->face_count()));
    measure_surface(cage, reference, samples_per_edge + 1, error);
    measure_curves(cage, fitted, reference, 2 * samples_per_edge, error);
    measure_reverse(cage, points, options.tolerance_mm, error);
    return error;
}

}  // namespace patchwright::fit
