#include <patchwright/base/error.h>
#include <patchwright/fit/interpolate.h>
#include <patchwright/subd/limit_operator.h>

#include <fmt/format.h>

#include <map>
#include <utility>

namespace patchwright::fit {

namespace {

/// A limit operator with a row a place.
class PlacesOperator final : public LinearOperator {
  public:
    PlacesOperator(const mesh::Topology& topology, std::span<const subd::Location> places)
        : limit_(make(topology, places)) {}
    [[nodiscard]] Eigen::Index rows() const override { return limit_.rows(); }
    [[nodiscard]] Eigen::Index columns() const override { return limit_.columns(); }
    void apply(const geom::Points& x, geom::Points& y) const override { limit_.apply(x, y); }
    void apply_transposed(const geom::Points& y, geom::Points& x) const override {
        limit_.apply_transposed(y, x);
    }
    Eigen::Array3d apply_with_norms(const geom::Points& x, geom::Points& y) const override {
        return limit_.apply_with_norms(x, y);
    }
    void subtract_and_transpose(const Eigen::Array3d& factor, const geom::Points& q,
                                geom::Points& r, geom::Points& x) const override {
        limit_.subtract_and_transpose(factor, q, r, x);
    }

  private:
    static subd::LimitOperator make(const mesh::Topology& topology,
                                    std::span<const subd::Location> places) {
        // Places at the same parameters share their masks.
        std::map<std::pair<double, double>, int> known;
        std::vector<subd::ParameterSet> sets;
        std::vector<subd::Site> sites;
        for (const subd::Location& at : places) {
            if (!(at.u >= 0.0 && at.u <= 1.0 && at.v >= 0.0 && at.v <= 1.0)) {
                throw base::InvalidArgument(fmt::format(
                    "face {}: parameters ({}, {}) are not on it", at.face.value, at.u, at.v));
            }
            const auto [entry, added] =
                known.try_emplace({at.u, at.v}, static_cast<int>(sets.size()));
            if (added) sets.push_back({Eigen::Vector2d(at.u, at.v)});
            sites.push_back({at.face, at.sector, entry->second});
        }
        return {topology, sets, sites};
    }

    subd::LimitOperator limit_;
};

}  // namespace

InterpolationResult interpolate(const mesh::Cage& cage, std::span<const subd::Location> places,
                                const geom::Points& targets, const InterpolationOptions& options) {
    if (targets.rows() != static_cast<Eigen::Index>(places.size())) {
        throw base::InvalidArgument(
            fmt::format("{} targets for {} places", targets.rows(), places.size()));
    }
    const PlacesOperator limit(*cage.topology, places);
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
            solve_cgls(limit, targets - at, geom::Points::Zero(limit.columns(), 3),
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
