#include "fit/loop/measure.h"

#include "fit/loop/sampling.h"

#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_operator.h>

#include <algorithm>

namespace patchwright::fit {

namespace {

using geom::Points;

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
            error.curves.add(distance[i], limit.row(Eigen::Index(i)).transpose());
            side = std::max(side, distance[i]);
        }
    }
}

}  // namespace

LevelError measure(const mesh::Cage& cage, const LevelFit& fitted,
                   const geom::ReferenceSurface& reference, const std::vector<geom::Vec3>& points,
                   const FitOptions& options) {
    const int samples_per_edge = options.solver.samples_per_edge;
    // Without progress: what a time limit has ended is measured all the same.
    const measure::LimitDeviation limit =
        measure::measure_limit(cage, reference, points,
                               {.intervals = samples_per_edge + 1, .far_mm = options.tolerance_mm});
    LevelError error{.surface = limit.surface, .curves = {}, .reverse = limit.reverse, .faces = {}};
    for (const CurveTarget& turn : fitted.match.turns) error.at_turns.push_back(turn.vertex);
    for (const measure::FaceDeviation& face : limit.faces) error.faces.push_back({face});
    measure_curves(cage, fitted, reference, 2 * samples_per_edge, error);
    return error;
}

}  // namespace patchwright::fit
