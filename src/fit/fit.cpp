#include "fit/level_fit.h"
#include "fit/sampling.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/fit/fit.h>
#include <patchwright/subd/limit_operator.h>
#include <patchwright/subd/normal_control.h>
#include <patchwright/subd/refine.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace patchwright::fit {

namespace {

using geom::Points;

/// Distances of a grid over all faces, borders included and denser than the one that was fitted.
Distances measure(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  int samples_per_edge) {
    const subd::LimitOperator limit_operator(*cage.topology, {closed_grid(samples_per_edge + 1)},
                                             face_sites(*cage.topology),
                                             subd::SampleRows::PointsAndTangents);
    Points limit;
    limit_operator.apply(cage.points, limit);
    const Points normals = limit_operator.normals(cage.points);
    std::vector<double> distance(static_cast<std::size_t>(limit.rows()));
    base::parallel_for(distance.size(), 64, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            const auto row = Eigen::Index(i);
            distance[i] = reference
                              .foot_point(limit.row(row).transpose(),
                                          unit_or_none(normals.row(row).transpose()))
                              .distance;
        }
    });
    Distances distances;
    for (const double d : distance) distances.add(d);
    return distances;
}

void check(const FitOptions& o) {
    const auto require = [](bool good, const char* what) {
        if (!good) throw base::InvalidArgument(fmt::format("fit: {}", what));
    };
    require(o.tolerance_mm > 0.0, "the tolerance must be positive");
    require(o.max_levels >= 0, "max_levels must not be negative");
    require(o.max_projections >= 0, "max_projections must not be negative");
    require(o.samples_per_edge >= 2, "samples_per_edge must be at least 2");
    require(o.fairness >= 0.0, "fairness must not be negative");
    require(o.max_cgls_iterations >= 1, "max_cgls_iterations must be positive");
}

}  // namespace

FitResult fit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
              const FitOptions& options) {
    check(options);
    FitResult result;
    result.cage = cage;
    for (;;) {
        const auto start = std::chrono::steady_clock::now();
        FitLevel level;
        level.vertices = result.cage.topology->vertex_count();
        level.faces = result.cage.topology->face_count();
        result.cage.points = fit_level(result.cage, reference, options, level);
        result.cage = subd::control_normals(result.cage);
        const Distances distances = measure(result.cage, reference, options.samples_per_edge);
        level.samples = static_cast<int>(distances.count);
        level.rms_mm = distances.rms();
        level.max_mm = distances.max;
        level.seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        result.levels.push_back(level);
        result.met = level.max_mm <= options.tolerance_mm;
        const bool room = static_cast<int>(result.levels.size()) <= options.max_levels &&
                          4 * level.vertices <= options.max_vertices;
        const std::size_t count = result.levels.size();
        const bool stuck =
            count > 1 && level.max_mm > options.least_gain * result.levels[count - 2].max_mm;
        if (result.met || !room || stuck) return result;
        result.cage = subd::refine(result.cage, 1);
    }
}

}  // namespace patchwright::fit
