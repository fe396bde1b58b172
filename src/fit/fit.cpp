#include "fit/sampling.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/fit/cgls.h>
#include <patchwright/fit/fit.h>
#include <patchwright/subd/limit_operator.h>
#include <patchwright/subd/normal_control.h>
#include <patchwright/subd/refine.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace patchwright::fit {

namespace {

using geom::Points;
using geom::Vec3;
using mesh::EdgeId;
using mesh::Topology;
using mesh::VertexId;

/// A limit operator whose held control points count as zero columns.
class HeldOperator final : public LinearOperator {
  public:
    HeldOperator(const subd::LimitOperator& full, const std::vector<char>& free)
        : full_(full), free_(free) {}
    [[nodiscard]] Eigen::Index rows() const override { return full_.rows(); }
    [[nodiscard]] Eigen::Index columns() const override { return full_.columns(); }
    // CGLS only ever applies it to combinations of its own transposed products: those are zero
    // there.
    void apply(const Points& x, Points& y) const override { full_.apply(x, y); }
    void apply_transposed(const Points& y, Points& x) const override {
        full_.apply_transposed(y, x);
        for (std::size_t v = 0; v < free_.size(); ++v) {
            if (free_[v] == 0) x.row(Eigen::Index(v)).setZero();
        }
    }

  private:
    const subd::LimitOperator& full_;
    const std::vector<char>& free_;
};

struct Distances {
    double sum_of_squares = 0.0;
    double max = 0.0;
    std::int64_t count = 0;

    void add(double distance) {
        sum_of_squares += distance * distance;
        max = std::max(max, distance);
        ++count;
    }
    [[nodiscard]] double rms() const {
        return count > 0 ? std::sqrt(sum_of_squares / double(count)) : 0.0;
    }
};

std::optional<Vec3> unit_or_none(const Vec3& v) {
    const double norm = v.norm();
    if (norm > 0.0) return Vec3(v / norm);
    return std::nullopt;
}

/// The fit on one level of refinement.
class LevelFit {
  public:
    LevelFit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
             const FitOptions& options)
        : topology_(*cage.topology),
          points_(cage.points),
          reference_(reference),
          options_(options),
          reach_(options.feature_reach_rel * reference.bounds().diagonal()),
          curves_(curve_sites(topology_)),
          surface_operator_(topology_, {interior_grid(options.samples_per_edge)},
                            face_sites(topology_), 1),
          curve_operator_(topology_, side_sets(options.samples_per_edge), curves_.sites),
          curve_free_(std::size_t(topology_.vertex_count()), 0),
          surface_free_(std::size_t(topology_.vertex_count()), 1) {
        classify_vertices();
    }

    /// Rounds of projecting and solving until near enough or no longer improving.
    Points run(FitLevel& level) {
        place_corners();
        Points best = points_;
        double best_max = std::numeric_limits<double>::infinity();
        double last_rms = std::numeric_limits<double>::infinity();
        int idle_rounds = 0;
        for (;;) {
            base::report_progress(options_.progress, "fit",
                                  double(level.projections) / options_.max_projections);
            Distances distances;
            solve_curves(level, distances);
            const Points targets = surface_targets(distances);
            if (distances.max < best_max) {
                best_max = distances.max;
                best = points_;
            }
            idle_rounds = distances.rms() > 0.98 * last_rms ? idle_rounds + 1 : 0;
            last_rms = distances.rms();
            if (distances.max < 0.25 * options_.tolerance_mm || idle_rounds == 2 ||
                level.projections == options_.max_projections) {
                return best;
            }
            solve(surface_operator_, surface_free_, targets, surface_limit_, level);
            ++level.projections;
        }
    }

  private:
    void classify_vertices() {
        std::vector<int> sharp_edges(curve_free_.size(), 0);
        for (const EdgeId e : topology_.edges()) {
            if (!std::isinf(topology_.sharpness(e))) continue;
            ++sharp_edges[topology_.start(e).index()];
            ++sharp_edges[topology_.end(e).index()];
        }
        for (const VertexId v : topology_.vertices()) {
            // The end of a crease inside the surface (dart) moves with the surface.
            curve_free_[v.index()] = sharp_edges[v.index()] > 1 ? 1 : 0;
            surface_free_[v.index()] = 1 - curve_free_[v.index()];
            if (topology_.is_pinned(v)) curve_free_[v.index()] = surface_free_[v.index()] = 0;
        }
    }

    void place_corners() {
        for (const VertexId v : corner_vertices(topology_)) {
            if (topology_.is_pinned(v)) continue;
            const Vec3 at = points_.row(v.value).transpose();
            const auto target = reference_.feature_point(at, geom::FeatureKind::Corner);
            if (!target || target->distance > reach_) continue;
            points_.row(v.value) = target->point.transpose();
            curve_free_[v.index()] = surface_free_[v.index()] = 0;
        }
    }

    Vec3 curve_target(const Vec3& limit, CurveKind kind) const {
        const auto feature = reference_.feature_point(
            limit, kind == CurveKind::Crease ? geom::FeatureKind::Sharp : geom::FeatureKind::Free);
        if (feature && feature->distance <= reach_) return feature->point;
        return reference_.foot_point(limit).point;
    }

    void solve_curves(FitLevel& level, Distances& distances) {
        if (curves_.sites.empty()) return;
        Points limit;
        Points targets(curve_operator_.rows(), 3);
        // Curves are cheap; two rounds keep them ahead of the surface, the third only measures.
        for (int round = 0; round < 3; ++round) {
            curve_operator_.apply(points_, limit);
            const auto& rows = curve_operator_.site_rows();
            base::parallel_for(curves_.sites.size(), 16, [&](std::size_t first, std::size_t last) {
                for (std::size_t site = first; site < last; ++site) {
                    for (auto row = rows[site]; row < rows[site + 1]; ++row) {
                        targets.row(row) =
                            curve_target(limit.row(row).transpose(), curves_.kinds[site])
                                .transpose();
                    }
                }
            });
            if (round < 2) solve(curve_operator_, curve_free_, targets, limit, level);
        }
        for (Eigen::Index i = 0; i < limit.rows(); ++i) {
            distances.add((limit.row(i) - targets.row(i)).norm());
        }
    }

    Points surface_targets(Distances& distances) {
        surface_operator_.apply(points_, surface_limit_);
        const Points normals = surface_operator_.normals(points_);
        Points targets(surface_limit_.rows(), 3);
        base::parallel_for(
            std::size_t(targets.rows()), 64, [&](std::size_t first, std::size_t last) {
                for (auto i = Eigen::Index(first); i < Eigen::Index(last); ++i) {
                    const Vec3 at = surface_limit_.row(i).transpose();
                    targets.row(i) =
                        reference_.foot_point(at, unit_or_none(normals.row(i).transpose())).point;
                }
            });
        for (Eigen::Index i = 0; i < targets.rows(); ++i) {
            distances.add((surface_limit_.row(i) - targets.row(i)).norm());
        }
        return targets;
    }

    void solve(const subd::LimitOperator& full, const std::vector<char>& free,
               const Points& targets, const Points& limit, FitLevel& level) {
        const HeldOperator held(full, free);
        const CglsResult step =
            solve_cgls(held, targets - limit, Points::Zero(held.columns(), 3),
                       {.max_iterations = options_.max_cgls_iterations, .relative_residual = 1e-4});
        points_ += step.x;
        level.cgls_steps += step.iterations;
    }

    const Topology& topology_;
    Points points_;
    const geom::ReferenceSurface& reference_;
    const FitOptions& options_;
    double reach_;
    CurveSampling curves_;
    subd::LimitOperator surface_operator_;
    subd::LimitOperator curve_operator_;
    std::vector<char> curve_free_;
    std::vector<char> surface_free_;
    Points surface_limit_;
};

/// Distances of a grid over all faces, borders included and denser than the one that was fitted.
Distances measure(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  int samples_per_edge) {
    const subd::LimitOperator limit_operator(*cage.topology, {closed_grid(samples_per_edge + 1)},
                                             face_sites(*cage.topology), 1);
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
        result.cage.points = LevelFit(result.cage, reference, options).run(level);
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
