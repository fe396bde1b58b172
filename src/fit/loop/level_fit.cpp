#include "fit/loop/level_fit.h"

#include "fit/loop/placement.h"
#include "fit/loop/projector.h"
#include "fit/loop/sampling.h"
#include "fit/loop/step_weights.h"
#include "fit/solve/symmetry.h"

#include <patchwright/base/error.h>
#include <patchwright/subd/normal_control.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace patchwright::fit {

namespace {

using geom::Points;
using geom::Vec3;
using mesh::Topology;
using mesh::VertexId;

// A step that leaves more than this share of the energy gains little: what goes on slowly is the
// drift of parameters, and refining gains more. Two such steps end a level.
constexpr double little_gain_share = 0.85;
// The same within the tolerance, where nothing is refined and what is delivered is to be fair.
constexpr double little_finishing_gain_share = 0.97;
constexpr int max_little_gains = 2;
// Share of the tolerance at which nothing is left to gain.
constexpr double finished_share = 0.02;
// While the bending energy has more weight than this it may hold distances back.
constexpr double small_fairness = 1e-5;
// Tangential motion by a face's width in faces that are folded when given counts as a distance of
// so many tolerances.
constexpr double fold_scale_rel = 1.0;
// Regularisation must not drive the surface away, nor single samples, which weigh little once they
// are in a fold: no step may leave more than this times the least rms of distances so far.
constexpr double max_growth = 1.4;
// Of moves along with curves, see carried_along(): what is rows away has its own way to go.
constexpr double fading = 0.1;
// As surface_residual: curves are held once they are fitted.
constexpr double curve_residual = 1e-4;

/// @pre not empty
double largest_distance(const std::vector<measure::NearLimit>& near) {
    return std::ranges::max(near, {}, &measure::NearLimit::distance).distance;
}

/// The linear problems of steps of one kind.
struct StepProblem {
    const subd::LimitOperator& samples;
    const PointConstraints& constraints;
    const Regularisation& regularisation;
    std::function<Projection(const Points& points, const Projection* last)> project;
};

class LevelFitter {
  public:
    LevelFitter(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                const std::vector<Vec3>& reverse_points, const FitOptions& options,
                const LevelStart& start, FitLevel& level)
        : topology_(*cage.topology),
          points_(cage.points),
          reference_(reference),
          reverse_points_(reverse_points),
          options_(options),
          level_(level),
          projector_(cage, reference, options, start.foot_reach, [this] { poll(0.0); }),
          face_regularisation_(Regularisation::of_surface(
              topology_, points_, options.preserve_parametrisation ? tangential_scale_mm() : 0.0,
              options.solver.evens_lines)),
          curve_regularisation_(Regularisation::of_curves(topology_, projector_.curves().sites,
                                                          points_, tangential_scale_mm())),
          preconditioner_(topology_),
          curve_steps_{.held = std::vector<std::uint8_t>(std::size_t(topology_.vertex_count()))},
          surface_steps_(curve_steps_) {
        constrain_vertices();
        keep_symmetry();
        even_out_folds(start);
    }

    LevelFit run(bool curves_are_near) && {
        bool stopped = false;
        try {
            improve_curves(curves_are_near);
            settle_corners();
            improve_surface(options_.solver.fairness, options_.solver.max_projections);
            improve_reverse_distances();
        } catch (const base::TimeLimitReached&) {
            stopped = true;
        }
        return {std::move(points_), projector_.curves(), projector_.match(), symmetry_axis_,
                stopped};
    }

  private:
    [[nodiscard]] double tangential_scale_mm() const {
        return options_.solver.tangential_scale_rel * options_.tolerance_mm;
    }

    void poll(double share_of_round) const {
        base::report_progress(options_.progress, "fit",
                              std::min((round_ + share_of_round) / std::max(rounds_, 1), 1.0));
    }

    /// Crease and boundary curves depend on their own control points only.
    void improve_curves(bool are_near) {
        if (projector_.curves().sites.empty()) return;
        const Points before = points_;
        improve({projector_.curve_samples(), curve_steps_, curve_regularisation_,
                 [&](const Points& p, const Projection*) { return projector_.project_curves(p); }},
                0.0, (options_.solver.max_projections + 1) / 2);
        if (!are_near) carry_along(before);
    }

    /// Narrow strips that are left behind by their curve would stand on end.
    void carry_along(const Points& before) {
        const auto& held = surface_steps_.held;
        Moves moves;
        for (const VertexId v : topology_.vertices())
            if (held[v.index()] == PointConstraints::all)
                moves[v] = (points_.row(v.value) - before.row(v.value)).transpose();
        const auto along = carried_along(topology_, before, moves, fading);
        if (!along) return;
        for (Eigen::Index v = 0; v < points_.rows(); ++v)
            for (int c = 0; c < 3; ++c)
                if ((held[std::size_t(v)] >> c & 1) == 0) points_(v, c) += (*along)(v, c);
        surface_steps_.follow(points_);
    }

    /// Where three or four quads meet at a corner between sharp edges.
    void settle_corners() {
        corners_.emplace(topology_, points_, surface_steps_.held);
        surface_steps_.corners = &*corners_;
        settle(points_);
    }

    void settle(Points& points) {
        if (!corners_) return;
        corners_->settle(points);
        surface_steps_.follow(points);
    }

    void improve_surface(double fairness, int rounds) {
        improve({projector_.face_samples(), surface_steps_, face_regularisation_,
                 [&](const Points& p, const Projection* last) {
                     return projector_.project_surface(p, last);
                 }},
                fairness, rounds);
    }

    /// Adds targets for points of the reference that are far from the limit surface although its
    /// own samples are near, as beyond the crest of a narrow ridge, on whose sides these have their
    /// foot points.
    void improve_reverse_distances() {
        if (reverse_points_.empty()) return;
        const std::vector<measure::NearLimit> near = projector_.nearest(points_, reverse_points_);
        const double before = largest_distance(near);
        if (before <= options_.tolerance_mm) return;
        std::vector<Vec3> targets;
        for (std::size_t i = 0; i < near.size(); ++i) {
            if (near[i].distance > reverse_target_share * options_.tolerance_mm)
                targets.push_back(reverse_points_[i]);
        }
        const Points without = points_;
        projector_.set_reverse_targets(std::move(targets));
        const double forward = projector_.project_surface(points_, nullptr).distances.max;
        try {
            improve_surface(0.0, options_.solver.max_projections / 2);
        } catch (const base::TimeLimitReached&) {
            points_ = without;  // only all steps together are known to be an improvement
            throw;
        }
        projector_.set_reverse_targets({});
        const double after =
            std::max(largest_distance(projector_.nearest(points_, reverse_points_)),
                     projector_.project_surface(points_, nullptr).distances.max);
        if (after > std::max(before, forward)) points_ = without;
    }

    /// Where the given cage is folded its parametrisation is not worth preserving.
    void even_out_folds(const LevelStart& start) {
        const auto sites = face_sites(topology_);
        const auto& rows = projector_.face_samples().site_rows();
        std::vector<char> near(std::size_t(topology_.vertex_count()), 0);
        for (std::size_t site = 0; site < sites.size(); ++site)
            if (projector_.is_folded_when_given(rows[site], rows[site + 1]) ||
                (!start.folded.empty() &&
                 (start.folded[sites[site].face.index()] != 0 ||
                  projector_.is_inverted_when_given(rows[site], rows[site + 1]))))
                for (const auto c : topology_.corners(sites[site].face))
                    near[topology_.vertex(c).index()] = 1;
        for (std::size_t site = 0; site < sites.size(); ++site) {
            bool any = false;
            for (const auto c : topology_.corners(sites[site].face))
                any = any || near[topology_.vertex(c).index()] != 0;
            if (!any) continue;
            face_regularisation_.even_out(site, fold_scale_rel * options_.tolerance_mm);
            evened_sites_.push_back(site);
        }
    }

    void constrain_vertices() {
        std::vector<int> sharp_edges(curve_steps_.held.size(), 0);
        for (const mesh::EdgeId e : topology_.edges()) {
            if (!std::isinf(topology_.sharpness(e))) continue;
            ++sharp_edges[topology_.start(e).index()];
            ++sharp_edges[topology_.end(e).index()];
        }
        for (const VertexId v : topology_.vertices()) {
            const bool on_curve = sharp_edges[v.index()] > 1;
            (on_curve ? surface_steps_ : curve_steps_).held[v.index()] = PointConstraints::all;
            if (topology_.is_pinned(v)) hold(v, PointConstraints::all);
        }
        const FeatureMatch& match = projector_.match();
        // The end of a crease inside the surface moves with both.
        for (const CurveTarget& dart : match.darts) {
            if (!topology_.is_pinned(dart.vertex)) curve_steps_.held[dart.vertex.index()] = 0;
        }
        for (const VertexTarget& target : match.corners) {
            if (topology_.is_pinned(target.vertex)) continue;
            points_.row(target.vertex.value) = target.point.transpose();
            hold(target.vertex, PointConstraints::all);
        }
        level_.chains_on_features =
            static_cast<int>(std::count_if(match.paths.begin(), match.paths.end(),
                                           [](const auto& path) { return !path.empty(); }));
    }

    void hold(VertexId v, std::uint8_t coordinates) {
        curve_steps_.held[v.index()] |= coordinates;
        surface_steps_.held[v.index()] |= coordinates;
    }

    void keep_symmetry() {
        const std::optional<SymmetryPlane> plane = find_symmetry(
            topology_, points_, projector_.curves(), projector_.match(), reference_, options_);
        if (!plane) return;
        symmetry_axis_ = plane->axis;
        for (const int v : plane->vertices) {
            if (topology_.is_pinned(VertexId{v})) continue;
            points_(v, plane->axis) = 0.0;
            hold(VertexId{v}, std::uint8_t(1 << plane->axis));
        }
        for (PointConstraints* steps : {&curve_steps_, &surface_steps_}) {
            steps->followers = plane->followers;
            steps->axis = plane->axis;
        }
        surface_steps_.follow(points_);
    }

    /// Gauss-Newton steps with Levenberg-Marquardt damping: targets, directions and weights are
    /// fixed during a step. A step that increases the energy is not taken.
    void improve(const StepProblem& problem, double fairness, int rounds) {
        rounds_ = rounds;
        round_ = 0;
        Projection now = problem.project(points_, nullptr);
        StepWeights weights(points_.rows(), fairness);
        double least = now.distances.rms();
        int little_gains = 0;
        for (; round_ < rounds; ++round_) {
            poll(0.0);
            if (now.distances.max < finished_share * options_.tolerance_mm && !is_folded(now))
                return;
            (now.of_curves ? now.weights.along : now.weights.across) = weights.tangential;
            // Bending has fewer samples a face than the surface, and they count alike.
            const double share =
                double(problem.samples.rows()) / double(problem.regularisation.rows().rows());
            const RegularisationWeights regular =
                problem.regularisation.weights_at(points_, weights.fairness * share, share);
            const Points step = solve(problem, now, regular, weights.damping);
            // Raised until the solve takes the step for none: none of any length helps.
            if (weights.are_raised() && !(step.cwiseAbs().maxCoeff() > step_tolerance_mm_)) return;
            Points candidate = points_ + step;
            settle(candidate);
            Projection next = problem.project(candidate, &now);
            ++level_.projections;
            const Inversion inversion = inverted_by(problem, now, next);
            const bool shorter = weights.shorten_at(corners_of(inversion.sites, now.of_curves));
            if (inversion.more && shorter) continue;
            const double was = now.energy(now.weights), is = next.energy(now.weights);
            const double before = was + problem.regularisation.energy(points_, regular);
            const double after = is + problem.regularisation.energy(candidate, regular);
            if (inversion.more || !(after < before) || next.distances.rms() > max_growth * least) {
                if (!weights.after_refused()) return;
                continue;
            }
            least = std::min(least, next.distances.rms());
            points_ = candidate;
            now = std::move(next);
            const double little_gain = now.distances.max > options_.tolerance_mm
                                           ? little_gain_share
                                           : little_finishing_gain_share;
            const bool little = is > little_gain * was && weights.fairness < small_fairness;
            little_gains = little ? little_gains + 1 : 0;
            weights.after_taken();
            if (little_gains == max_little_gains) return;
        }
    }

    /// Whether folds of the given cage are left.
    [[nodiscard]] bool is_folded(const Projection& now) const {
        if (now.of_curves) return false;
        const auto& rows = projector_.face_samples().site_rows();
        return std::any_of(evened_sites_.begin(), evened_sites_.end(), [&](std::size_t site) {
            for (auto i = rows[site]; i < rows[site + 1]; ++i)
                if (now.is_inverted(i)) return true;
            return false;
        });
    }

    /// Displacements of the control points.
    Points solve(const StepProblem& problem, const Projection& now,
                 const RegularisationWeights& regular, const Eigen::VectorXd& damping) {
        const StepOperator step(problem.samples, now.weights, problem.regularisation.rows(),
                                regular.rows, damping, problem.constraints);
        step.precondition(preconditioner_);
        const CglsResult solution =
            solve_cgls(step,
                       step.right_side(now.target - now.limit,
                                       problem.regularisation.changes(points_, regular)),
                       Points::Zero(step.columns(), 3),
                       {.max_iterations = options_.solver.max_cgls_iterations,
                        .relative_residual = now.of_curves ? curve_residual : surface_residual,
                        .step_tolerance = step_tolerance_mm_,
                        .unknown_sizes = &step.scale(),
                        .preconditioner = &preconditioner_,
                        .joint = true,
                        .progress = [this](std::string_view, double share) {
                            poll(share);
                            return true;
                        }});
        level_.cgls_steps += solution.iterations;
        level_.solves_by_step_tolerance += solution.stop == CglsStop::StepTolerance ? 1 : 0;
        level_.solves_by_max_iterations += solution.stop == CglsStop::MaxIterations ? 1 : 0;
        return step.displacements(solution.x);
    }

    /// Nothing where the given parametrisation is not preserved.
    [[nodiscard]] Inversion inverted_by(const StepProblem& problem, const Projection& now,
                                        const Projection& next) const {
        if (!now.of_curves && !options_.preserve_parametrisation) return {};
        const auto& rows = problem.samples.site_rows();
        Inversion inversion = inverted_by_step(rows, now, next);
        if (!now.of_curves)
            std::erase_if(inversion.sites, [&](std::size_t site) {
                return projector_.is_inverted_when_given(rows[site], rows[site + 1]);
            });
        return inversion;
    }

    [[nodiscard]] std::set<VertexId> corners_of(const std::vector<std::size_t>& sites,
                                                bool of_curves) const {
        const auto all = of_curves ? projector_.curves().sites : face_sites(topology_);
        std::set<VertexId> corners;
        for (const std::size_t site : sites)
            for (const auto c : topology_.corners(all[site].face))
                corners.insert(topology_.vertex(c));
        return corners;
    }

    const Topology& topology_;
    Points points_;
    const geom::ReferenceSurface& reference_;
    const std::vector<Vec3>& reverse_points_;
    const FitOptions& options_;
    FitLevel& level_;
    const double step_tolerance_mm_ = options_.solver.step_tolerance_rel * options_.tolerance_mm;
    int round_ = 0, rounds_ = 0;
    Projector projector_;
    Regularisation face_regularisation_, curve_regularisation_;
    MeshPreconditioner preconditioner_;
    PointConstraints curve_steps_, surface_steps_;
    std::optional<int> symmetry_axis_;
    std::optional<subd::CornerSectors> corners_;
    std::vector<std::size_t> evened_sites_;  ///< of faces, folded when given
};

}  // namespace

LevelFit given_level(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                     const FitOptions& options) {
    LevelFit given;
    given.points = cage.points;
    given.curves = curve_sites(*cage.topology);
    given.match = match_cage(cage, given.curves,
                             curve_points(cage, given.curves, options.solver.samples_per_edge),
                             reference, options);
    return given;
}

LevelFit fit_level(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                   const std::vector<Vec3>& points, const FitOptions& options,
                   const LevelStart& start, FitLevel& level) {
    return LevelFitter(cage, reference, points, options, start, level).run(start.refined);
}

}  // namespace patchwright::fit
