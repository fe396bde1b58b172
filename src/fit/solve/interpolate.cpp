#include "fit/solve/limit_rows.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/interpolate.h>
#include <patchwright/subd/limit_operator.h>

#include <fmt/format.h>

#include <map>
#include <utility>

namespace patchwright::fit {

namespace {

/// With a row a place.
subd::LimitOperator places_operator(const mesh::Topology& topology,
                                    std::span<const subd::Location> places) {
    // Places at the same parameters share their masks.
    std::map<std::pair<double, double>, int> known;
    std::vector<subd::ParameterSet> sets;
    std::vector<subd::Site> sites;
    for (const subd::Location& at : places) {
        if (!(at.u >= 0.0 && at.u <= 1.0 && at.v >= 0.0 && at.v <= 1.0)) {
            throw base::InvalidArgument(fmt::format("face {}: parameters ({}, {}) are not on it",
                                                    at.face.value, at.u, at.v));
        }
        const auto [entry, added] = known.try_emplace({at.u, at.v}, static_cast<int>(sets.size()));
        if (added) sets.push_back({Eigen::Vector2d(at.u, at.v)});
        sites.push_back({at.face, at.sector, entry->second});
    }
    return {topology, sets, sites};
}

}  // namespace

InterpolationResult interpolate(const mesh::Cage& cage, std::span<const subd::Location> places,
                                const geom::Points& targets, const InterpolationOptions& options) {
    if (targets.rows() != static_cast<Eigen::Index>(places.size())) {
        throw base::InvalidArgument(
            fmt::format("{} targets for {} places", targets.rows(), places.size()));
    }
    const subd::LimitOperator limit = places_operator(*cage.topology, places);
    InterpolationResult result{.cage = cage};
    geom::Points at;
    limit.apply(cage.points, at);
    const auto largest = [&] {
        return targets.rows() == 0 ? 0.0 : (targets - at).rowwise().norm().maxCoeff();
    };
    result.largest_distance = largest();
    const double goal = options.relative_residual * result.largest_distance;
    // Started from the cage, every step of CGLS stays in the row space: of all solutions it finds
    // the nearest. What rounding leaves is the problem of another, much smaller solution.
    for (int pass = 0; pass < 4 && result.largest_distance > goal; ++pass) {
        const CglsResult step =
            solve_cgls(LimitRows(limit), targets - at, geom::Points::Zero(limit.columns(), 3),
                       {.max_iterations = options.max_iterations - result.iterations,
                        .relative_residual = 1e-10,
                        .progress = options.progress});
        result.cage.points += step.x;
        result.iterations += step.iterations;
        limit.apply(result.cage.points, at);
        const double now = largest();
        if (!(now < 0.5 * result.largest_distance)) {
            result.largest_distance = now;
            break;
        }
        result.largest_distance = now;
    }
    result.met = result.largest_distance <= goal;
    return result;
}

InterpolationResult interpolate_vertices(const mesh::Cage& cage, const geom::Points& targets,
                                         const InterpolationOptions& options) {
    const mesh::Topology& t = *cage.topology;
    std::vector<subd::Location> places;
    for (const mesh::VertexId v : t.vertices()) {
        places.push_back(subd::corner_location(t, t.corner(v)));
    }
    return interpolate(cage, places, targets, options);
}

}  // namespace patchwright::fit
