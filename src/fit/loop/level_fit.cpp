#include "fit/loop/level_fit.h"

#include "fit/loop/coverage.h"
#include "fit/loop/projection.h"
#include "fit/loop/sampling.h"
#include "fit/match/dart_samples.h"
#include "fit/solve/step_operator.h"
#include "fit/solve/stiffness.h"
#include "fit/solve/symmetry.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>

#include <algorithm>
#include <cmath>

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
// Share of the tolerance at which a fit ends: what is gained beyond costs fairness.
constexpr double enough = 0.4;
// A foot point that is farther from its normal than this is on a border or an edge: the residual
// then counts in all directions.
constexpr double slanted = 0.3;
// Steps of a level that are made again for that.
constexpr int most_repeats = 10;
// Sliding by as much as a face is wide counts as much as missing by this share of the tolerance:
// enough against what drifts for nothing, too little to keep curves and noses from their place.
constexpr double slack = 0.1;

Points limit_of(const Topology& topology, const CurveSampling& curves, int samples_per_edge,
                const Points& points) {
    Points limit;
    subd::LimitOperator(topology, side_sets(samples_per_edge), curves.sites).apply(points, limit);
    return limit;
}

FeatureMatch match_of(const Topology& topology, const Points& points, const CurveSampling& curves,
                      const Points& curve_points, const geom::ReferenceSurface& reference,
                      const FitOptions& options) {
    return match_features(topology, points, curves, curve_points, options.solver.samples_per_edge,
                          reference, options.feature_reach_rel * reference.bounds().diagonal());
}

class LevelFitter {
  public:
    LevelFitter(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                const std::vector<Vec3>& reverse_points, const FitOptions& options,
                double side_reach, FitLevel& level)
        : topology_shared_(cage.topology),
          topology_(*cage.topology),
          points_(cage.points),
          reference_(reference),
          reverse_points_(reverse_points),
          options_(options),
          side_reach_(side_reach),
          level_(level),
          curves_(curve_sites(topology_)),
          given_curves_(limit_of(topology_, curves_, options.solver.samples_per_edge, points_)),
          match_(match_of(topology_, points_, curves_, given_curves_, reference, options)),
          darts_(topology_, curves_, match_, reference),
          surface_(topology_, surface_sets(options.solver.samples_per_edge),
                   darts_.after_faces(face_sites(topology_)), subd::SampleRows::PointsAndTangents),
          stiffness_(FormStiffness::of_surface(
              topology_, points_, options.preserve_parametrisation ? slack_mm() : 0.0)),
          curve_stiffness_(FormStiffness::of_curves(topology_, curves_.sites, points_, slack_mm())),
          curve_(topology_, curve_sets(options.solver.samples_per_edge),
                 darts_.after_curves(curves_.sites)),
          preconditioner_(topology_),
          curve_steps_{.held = std::vector<std::uint8_t>(std::size_t(topology_.vertex_count()))},
          surface_steps_(curve_steps_) {
        given_normals_ = surface_.normals(points_);
        surface_.apply(points_, given_limit_);
        hold_vertices();
        keep_symmetry();
    }

    LevelFit run() && {
        bool stopped = false;
        try {
            improve_all();
        } catch (const base::TimeLimitReached&) {
            stopped = true;
        }
        return {std::move(points_), std::move(curves_), std::move(match_), symmetry_axis_, stopped};
    }

  private:
    void improve_all() {
        if (!curves_.sites.empty()) {
            // Crease and boundary curves depend on their own control points only.
            improve(curve_, curve_steps_, curve_stiffness_, 0.0,
                    (options_.solver.max_projections + 1) / 2,
                    [&](const Points& p, const Projection*) { return project_curves(p); });
        }
        improve_surface(options_.solver.fairness, options_.solver.max_projections);
        cover();
    }

    void improve_surface(double fairness, int rounds) {
        improve(surface_, surface_steps_, stiffness_, fairness, rounds,
                [&](const Points& p, const Projection* last) { return project_surface(p, last); });
    }

    /// Draws the surface to points of the reference that it does not come near, as beyond the
    /// crest of a narrow ridge where feet of limit points lie on its sides.
    void cover() {
        if (reverse_points_.empty()) return;
        search_.emplace(topology_shared_);
        const auto farthest = [&](const std::vector<NearLimit>& near) {
            double most = 0.0;
            for (const NearLimit& n : near) most = std::max(most, n.distance);
            return most;
        };
        std::vector<NearLimit> near = search_->nearest(points_, reverse_points_);
        const double before = farthest(near);
        if (before <= options_.tolerance_mm) return;
        for (std::size_t i = 0; i < near.size(); ++i) {
            if (near[i].distance > enough * options_.tolerance_mm)
                uncovered_.push_back(reverse_points_[i]);
        }
        const Points without = points_;
        const double forward = project_surface(points_, nullptr).distances.max;
        try {
            improve_surface(0.0, options_.solver.max_projections / 2);
        } catch (const base::TimeLimitReached&) {
            points_ = without;  // steps are good or bad only once all of them are made
            throw;
        }
        uncovered_.clear();
        const double after = std::max(farthest(search_->nearest(points_, reverse_points_)),
                                      project_surface(points_, nullptr).distances.max);
        if (after > std::max(before, forward)) points_ = without;
    }

    /// Asks the samples next to the limit points that are nearest to uncovered points to go with
    /// these.
    void draw_to_uncovered(const Points& points, Projection& p) const {
        if (uncovered_.empty()) return;
        const int n = options_.solver.samples_per_edge;
        const std::vector<NearLimit> near = search_->nearest(points, uncovered_);
        std::vector<double> drawn(std::size_t(p.limit.rows()), enough * options_.tolerance_mm);
        for (std::size_t k = 0; k < near.size(); ++k) {
            const auto cell = [&](double t) { return std::min(int(t * n), n - 1); };
            const Eigen::Index i = surface_.site_rows()[std::size_t(near[k].site)] +
                                   cell(near[k].u) * n + cell(near[k].v);
            const Vec3 way = uncovered_[k] - near[k].point;
            // Beyond an open border the nearest limit point is no foot point.
            const bool beside = std::abs(way.dot(near[k].normal)) < 0.5 * near[k].distance;
            if (beside || !(near[k].distance > drawn[std::size_t(i)])) continue;
            drawn[std::size_t(i)] = near[k].distance;
            p.target.row(i) = p.limit.row(i) + way.transpose();
            p.weights.direction.row(i) = way.transpose() / near[k].distance;
            p.weights.weight[i] = 1.0;
        }
    }

    [[nodiscard]] double slack_mm() const { return slack * options_.tolerance_mm; }

    void hold_vertices() {
        std::vector<int> sharp_edges(curve_steps_.held.size(), 0);
        for (const EdgeId e : topology_.edges()) {
            if (!std::isinf(topology_.sharpness(e))) continue;
            ++sharp_edges[topology_.start(e).index()];
            ++sharp_edges[topology_.end(e).index()];
        }
        for (const VertexId v : topology_.vertices()) {
            const bool on_curve = sharp_edges[v.index()] > 1;
            (on_curve ? surface_steps_ : curve_steps_).held[v.index()] = PointConstraints::all;
            if (topology_.is_pinned(v)) hold(v, PointConstraints::all);
        }
        // The end of a crease inside the surface moves with both.
        for (const FeatureMatch::Dart& dart : match_.darts) {
            if (!topology_.is_pinned(dart.vertex)) curve_steps_.held[dart.vertex.index()] = 0;
        }
        for (const FeatureMatch::Place& place : match_.places) {
            if (topology_.is_pinned(place.vertex)) continue;
            points_.row(place.vertex.value) = place.point.transpose();
            hold(place.vertex, PointConstraints::all);
        }
        level_.chains_on_features =
            static_cast<int>(std::count_if(match_.paths.begin(), match_.paths.end(),
                                           [](const auto& path) { return !path.empty(); }));
    }

    void hold(VertexId v, std::uint8_t coordinates) {
        curve_steps_.held[v.index()] |= coordinates;
        surface_steps_.held[v.index()] |= coordinates;
    }

    void keep_symmetry() {
        const SymmetryPlane plane =
            find_symmetry(topology_, points_, curves_, match_, reference_, options_);
        if (plane.axis < 0) return;
        symmetry_axis_ = plane.axis;
        for (const int v : plane.vertices) {
            if (topology_.is_pinned(VertexId{v})) continue;
            points_(v, plane.axis) = 0.0;
            hold(VertexId{v}, std::uint8_t(1 << plane.axis));
        }
        for (PointConstraints* steps : {&curve_steps_, &surface_steps_}) {
            steps->followers = plane.followers;
            steps->axis = plane.axis;
        }
        surface_steps_.follow(points_);
    }

    /// Damped steps, each on the problem that is linear in the points once targets, directions and
    /// weights are fixed. A step that makes the result worse is not taken.
    template <class Project>
    void improve(const subd::LimitOperator& samples, const PointConstraints& constraints,
                 FormStiffness& form, double fairness, int rounds, const Project& project) {
        Projection now = project(points_, nullptr);
        double damping = 1e-6;
        double sliding = 0.3;
        int idle = 0;
        double least = now.energy(now.weights);
        int repeats = 0;
        for (int round = 0; round < rounds; ++round) {
            const base::Progress solving = [&](std::string_view, double done) {
                base::report_progress(options_.progress, "fit", (round + done) / rounds);
                return true;
            };
            base::report_progress(solving, "fit", 0.0);
            if (now.distances.max < enough * options_.tolerance_mm) return;
            (now.of_curves ? now.weights.along : now.weights.across) = sliding;
            // Bending has fewer samples a face than the surface, and they count alike.
            const double share = double(samples.rows()) / double(form.rows().rows());
            const Stiffness stiff = form.around(points_, fairness * share, share);
            const StepOperator step(samples, now.weights, form.rows(), stiff.rows, damping,
                                    constraints);
            step.precondition(preconditioner_);
            const CglsResult solution = solve_cgls(
                step, step.right_side(now.target - now.limit, form.changes(points_, stiff)),
                Points::Zero(step.columns(), 3),
                {.max_iterations = options_.solver.max_cgls_iterations,
                 .relative_residual = 1e-4,
                 .step_tolerance = options_.solver.step_tolerance_rel * options_.tolerance_mm,
                 .unknown_sizes = &step.scale(),
                 .preconditioner = &preconditioner_,
                 .joint = true,
                 .progress = solving});
            const Points candidate = points_ + step.displacements(solution.x);
            Projection next = project(candidate, &now);
            level_.cgls_steps += solution.iterations;
            level_.solves_by_step_tolerance += solution.stop == CglsStop::StepTolerance ? 1 : 0;
            level_.solves_by_max_iterations += solution.stop == CglsStop::MaxIterations ? 1 : 0;
            ++level_.projections;
            const bool folds =
                (now.of_curves || options_.preserve_parametrisation) &&
                hold_folds(form, samples.site_rows(), now, next, slack_mm(),
                           [&](auto first, auto end) {
                               return now.of_curves || !folded_when_given(first, end);
                           });
            if (folds && repeats++ < most_repeats) continue;
            const double was = now.energy(now.weights), is = next.energy(now.weights);
            const double before = was + form.energy(points_, stiff);
            const double after = is + form.energy(candidate, stiff);
            // Holding on to the given form must not drive the surface away.
            if (folds || !(after < before) || is > 2.0 * least) {
                if (sliding < 1.0) {
                    sliding = 1.0;
                } else {
                    damping *= 30.0;
                    if (damping > 10.0) return;
                }
                continue;
            }
            const bool little = is > little_gain * was;
            least = std::min(least, is);
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

    /// Whether the form of a face is one to leave.
    [[nodiscard]] bool folded_when_given(std::int32_t first, std::int32_t end) const {
        for (auto i = first; i < end; ++i) {
            const Vec3 normal = given_normals_.row(i).transpose();
            const Vec3 at = given_limit_.row(i).transpose();
            if (normal.dot(reference_.foot_point(at).normal) < 0.0) return true;
        }
        return false;
    }

    [[nodiscard]] Projection project_curves(const Points& points) const {
        Projection p = start(curve_, points);
        p.of_curves = true;
        const auto& rows = curve_.site_rows();
        p.sense.resize(p.limit.rows(), 3);
        p.extent.resize(p.limit.rows());
        base::parallel_for(curves_.sites.size(), 16, [&](std::size_t first, std::size_t last) {
            for (std::size_t site = first; site < last; ++site) {
                for (auto row = rows[site]; row < rows[site + 1]; ++row) {
                    const Vec3 at = p.limit.row(row).transpose();
                    const auto before = std::max(row - 1, rows[site]);
                    const auto next = std::min(row + 1, rows[site + 1] - 1);
                    const Eigen::RowVector3d given =
                        given_curves_.row(next) - given_curves_.row(before);
                    p.sense.row(row) = p.limit.row(next) - p.limit.row(before);
                    p.extent[row] = p.sense.row(row).dot(given) / given.squaredNorm();
                    const FeaturePath& path =
                        match_.paths[std::size_t(curves_.chain_of_site[site])];
                    if (path.empty()) {
                        p.target.row(row) = reference_.foot_point(at).point.transpose();
                    } else {
                        const auto feature = nearest_on_path(reference_, path, at);
                        p.target.row(row) = feature.point.transpose();
                        set_direction(p, row, feature.tangent, false);
                    }
                }
            }
        });
        darts_.project(curve_, p);
        return finished(std::move(p));
    }

    [[nodiscard]] Projection project_surface(const Points& points, const Projection* last) const {
        Projection p = start(surface_, points);
        p.sense = surface_.normals(points);
        p.extent.resize(p.limit.rows());
        const auto on_faces = std::size_t(darts_.rows_before(surface_, false));
        base::parallel_for(on_faces, 64, [&](std::size_t first, std::size_t end) {
            for (auto i = Eigen::Index(first); i < Eigen::Index(end); ++i) {
                const auto side = unit_or_none(p.sense.row(i).transpose());
                const geom::FootPoint foot =
                    foot_on_side(reference_, p.limit.row(i).transpose(), side, side_reach_);
                p.target.row(i) = foot.point.transpose();
                p.extent[i] = p.sense.row(i).dot(foot.normal) / given_normals_.row(i).norm();
                set_direction(p, i, foot.normal, true);
                p.weights.weight[i] =
                    trust(p, last, i, side ? foot.normal.dot(*side) : 1.0, options_.tolerance_mm);
            }
        });
        draw_to_uncovered(points, p);
        darts_.project(surface_, p);
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

    std::shared_ptr<const Topology> topology_shared_;
    const Topology& topology_;
    Points points_;
    const geom::ReferenceSurface& reference_;
    const std::vector<Vec3>& reverse_points_;
    const FitOptions& options_;
    double side_reach_;
    FitLevel& level_;
    CurveSampling curves_;
    Points given_curves_;  // of the samples of curves_
    FeatureMatch match_;
    DartSamples darts_;
    subd::LimitOperator surface_;
    FormStiffness stiffness_, curve_stiffness_;
    Points given_limit_, given_normals_;  // of the samples of surface_
    subd::LimitOperator curve_;
    MeshPreconditioner preconditioner_;
    PointConstraints curve_steps_, surface_steps_;
    std::optional<int> symmetry_axis_;
    std::optional<LimitSearch> search_;
    std::vector<Vec3> uncovered_;  // points of the reference that samples are drawn to
};

}  // namespace

LevelFit given_level(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                     const FitOptions& options) {
    LevelFit given{.points = cage.points, .curves = curve_sites(*cage.topology)};
    given.match = match_of(
        *cage.topology, cage.points, given.curves,
        limit_of(*cage.topology, given.curves, options.solver.samples_per_edge, cage.points),
        reference, options);
    return given;
}

LevelFit fit_level(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                   const std::vector<Vec3>& points, const FitOptions& options, double side_reach,
                   FitLevel& level) {
    return LevelFitter(cage, reference, points, options, side_reach, level).run();
}

}  // namespace patchwright::fit
