#include "fit/level_fit.h"

#include "fit/sampling.h"
#include "fit/step_operator.h"

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <limits>

namespace patchwright::fit {

namespace {

using geom::Points;
using geom::Vec3;
using mesh::EdgeId;
using mesh::Topology;
using mesh::VertexId;

// Part of the distance across a normal, or along a curve, that counts, squared: 1 is point
// distance, whose steps never make things worse but are short; less lets samples slide along the
// surface. Some stays, to keep them from sliding away.
constexpr double least_sliding = 0.01;
// Share of the energy that a step must not leave to count as progress. What goes on slowly is the
// creeping of parameters; refining gains more.
constexpr double little_gain = 0.85;
// A foot point that is farther from its normal than this is on a border or an edge: the residual
// then counts in all directions.
constexpr double slanted = 0.3;

/// Limit points of a control mesh, where they should be, and how their residuals count.
struct Projection {
    Points limit, target;
    SampleWeights weights;
    Distances distances;
    bool of_curves = false;

    [[nodiscard]] double energy() const { return distances.sum_of_squares; }
};

class LevelFit {
  public:
    LevelFit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
             const FitOptions& options, FitLevel& level)
        : topology_(*cage.topology),
          points_(cage.points),
          reference_(reference),
          options_(options),
          level_(level),
          reach_(options.feature_reach_rel * reference.bounds().diagonal()),
          curves_(curve_sites(topology_)),
          surface_(topology_, {interior_grid(options.samples_per_edge)}, face_sites(topology_),
                   subd::SampleRows::PointsAndTangents),
          bending_(topology_, {interior_grid(2)}, face_sites(topology_), subd::SampleRows::Bending),
          curve_(topology_, side_sets(options.samples_per_edge), curves_.sites),
          curve_free_(std::size_t(topology_.vertex_count()), 0),
          surface_free_(std::size_t(topology_.vertex_count()), 1) {
        classify_vertices();
    }

    Points run() {
        place_corners();
        if (!curves_.sites.empty()) {
            match_chains();
            // Crease and boundary curves depend on their own control points only.
            improve(curve_, curve_free_, 0.0, (options_.max_projections + 1) / 2,
                    [&](const Points& p) { return project_curves(p); });
        }
        improve(surface_, surface_free_, options_.fairness, options_.max_projections,
                [&](const Points& p) { return project_surface(p); });
        return points_;
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

    [[nodiscard]] geom::FeatureKind feature_kind(std::size_t site) const {
        return curves_.kinds[site] == CurveKind::Crease ? geom::FeatureKind::Sharp
                                                        : geom::FeatureKind::Free;
    }

    /// Decides once, for whole chains, whether a feature is what they belong to: near as compared
    /// with the model or with their own length.
    void match_chains() {
        std::vector<double> distance(std::size_t(curves_.chain_count), 0.0);
        std::vector<double> length(distance.size(), 0.0);
        std::vector<int> count(distance.size(), 0);
        Points limit;
        curve_.apply(points_, limit);
        const auto& rows = curve_.site_rows();
        for (std::size_t site = 0; site < curves_.sites.size(); ++site) {
            const auto chain = std::size_t(curves_.chains[site]);
            for (auto row = rows[site]; row < rows[site + 1]; ++row) {
                const auto feature =
                    reference_.feature_point(limit.row(row).transpose(), feature_kind(site));
                distance[chain] +=
                    feature ? feature->distance : std::numeric_limits<double>::infinity();
                ++count[chain];
                if (row > rows[site]) length[chain] += (limit.row(row) - limit.row(row - 1)).norm();
            }
        }
        matched_.resize(distance.size());
        for (std::size_t chain = 0; chain < matched_.size(); ++chain) {
            matched_[chain] =
                distance[chain] <= count[chain] * std::max(reach_, 0.1 * length[chain]) ? 1 : 0;
        }
    }

    /// Damped steps, each on the problem that is linear in the points once targets and directions
    /// are fixed. A step that makes the result worse is not taken.
    template <class Project>
    void improve(const subd::LimitOperator& samples, const std::vector<char>& free, double fairness,
                 int rounds, const Project& project) {
        Projection now = project(points_);
        double damping = 1e-6;
        double sliding = 0.3;
        int idle = 0;
        for (int round = 0; round < rounds; ++round) {
            base::report_progress(options_.progress, "fit", double(round) / rounds);
            if (now.distances.max < 0.25 * options_.tolerance_mm) return;
            (now.of_curves ? now.weights.along : now.weights.across) = sliding;
            // Bending has fewer samples a face than the surface, and they count alike.
            const double bending = fairness * double(samples.rows()) / double(bending_.rows());
            const StepOperator step(samples, now.weights, bending_, bending, damping, free);
            const CglsResult solution =
                solve_cgls(step, step.right_side(now.target - now.limit, points_),
                           Points::Zero(step.columns(), 3),
                           {.max_iterations = options_.max_cgls_iterations,
                            .relative_residual = 1e-4,
                            .joint = true});
            const Points candidate = points_ + step.displacements(solution.x);
            Projection next = project(candidate);
            level_.cgls_steps += solution.iterations;
            ++level_.projections;
            const double before = now.energy() + bending * bending_energy(points_);
            const double after = next.energy() + bending * bending_energy(candidate);
            if (!(after < before)) {
                if (sliding < 1.0) {
                    sliding = 1.0;
                } else {
                    damping *= 30.0;
                    if (damping > 10.0) return;
                }
                continue;
            }
            const bool little = next.energy() > little_gain * now.energy();
            points_ = candidate;
            now = std::move(next);
            damping = std::max(0.2 * damping, 1e-9);
            sliding = std::max(0.3 * sliding, least_sliding);
            // While it is lowered, bending may hold the distances back.
            idle = little && fairness < 1e-5 ? idle + 1 : 0;
            if (idle == 2) return;
            fairness *= 0.2;
        }
    }

    [[nodiscard]] double bending_energy(const Points& points) const {
        Points rows;
        bending_.apply(points, rows);
        return rows.squaredNorm();
    }

    [[nodiscard]] Projection project_curves(const Points& points) const {
        Projection p = start(curve_, points);
        p.of_curves = true;
        const auto& rows = curve_.site_rows();
        base::parallel_for(curves_.sites.size(), 16, [&](std::size_t first, std::size_t last) {
            for (std::size_t site = first; site < last; ++site) {
                for (auto row = rows[site]; row < rows[site + 1]; ++row) {
                    const Vec3 at = p.limit.row(row).transpose();
                    const bool matched = matched_[std::size_t(curves_.chains[site])] != 0;
                    if (matched) {
                        const auto feature = reference_.feature_point(at, feature_kind(site));
                        p.target.row(row) = feature->point.transpose();
                        set_direction(p, row, feature->tangent, false);
                    } else {
                        p.target.row(row) = reference_.foot_point(at).point.transpose();
                    }
                }
            }
        });
        return finished(std::move(p));
    }

    [[nodiscard]] Projection project_surface(const Points& points) const {
        Projection p = start(surface_, points);
        const Points normals = surface_.normals(points);
        base::parallel_for(std::size_t(p.limit.rows()), 64,
                           [&](std::size_t first, std::size_t last) {
                               for (auto i = Eigen::Index(first); i < Eigen::Index(last); ++i) {
                                   const auto side = unit_or_none(normals.row(i).transpose());
                                   const geom::FootPoint foot =
                                       reference_.foot_point(p.limit.row(i).transpose(), side);
                                   p.target.row(i) = foot.point.transpose();
                                   set_direction(p, i, foot.normal, true);
                                   // The wrong side, or a fold: not what this sample should be
                                   // drawn to.
                                   if (side && foot.normal.dot(*side) < 0.0)
                                       p.weights.weight[i] = 0.1;
                               }
                           });
        return finished(std::move(p));
    }

    [[nodiscard]] static Projection start(const subd::LimitOperator& samples,
                                          const Points& points) {
        Projection p;
        samples.apply(points, p.limit);
        p.target.resize(p.limit.rows(), 3);
        p.weights.direction = Points::Zero(p.limit.rows(), 3);
        p.weights.weight = Eigen::VectorXd::Ones(p.limit.rows());
        return p;
    }

    /// @param along  whether the residual should lie along the direction, else across it
    void set_direction(Projection& p, Eigen::Index row, const Vec3& direction, bool along) const {
        const Vec3 residual = (p.target.row(row) - p.limit.row(row)).transpose();
        const double length = residual.norm();
        const double cosine = std::abs(residual.dot(direction));
        const double off =
            along ? std::sqrt(std::max(0.0, length * length - cosine * cosine)) : cosine;
        if (off > slanted * length && length > 0.1 * options_.tolerance_mm) return;
        p.weights.direction.row(row) = direction.transpose();
    }

    [[nodiscard]] static Projection finished(Projection p) {
        for (Eigen::Index i = 0; i < p.limit.rows(); ++i) {
            p.distances.add((p.limit.row(i) - p.target.row(i)).norm());
        }
        return p;
    }

    const Topology& topology_;
    Points points_;
    const geom::ReferenceSurface& reference_;
    const FitOptions& options_;
    FitLevel& level_;
    double reach_;
    CurveSampling curves_;
    std::vector<char> matched_;  // by chain
    subd::LimitOperator surface_;
    subd::LimitOperator bending_;
    subd::LimitOperator curve_;
    std::vector<char> curve_free_;
    std::vector<char> surface_free_;
};

}  // namespace

Points fit_level(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                 const FitOptions& options, FitLevel& level) {
    return LevelFit(cage, reference, options, level).run();
}

}  // namespace patchwright::fit
