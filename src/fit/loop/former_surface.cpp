#include "fit/loop/former_surface.h"

#include "fit/loop/sampling.h"
#include "fit/loop/step_weights.h"
#include "fit/solve/regularisation.h"
#include "geom/bvh.h"
#include "measure/limit_search.h"

#include <patchwright/geom/nearest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

namespace patchwright::fit {

namespace {

using geom::Points;
using geom::Vec3;
using mesh::Topology;

// Foot points on a smooth surface settle soon; fits gain nothing from eight steps.
constexpr int return_steps = 5;
// Of the bending energy: makes the problem regular without holding distances back.
constexpr double bending_weight = 1e-6;
// Samples a side of faces, of sides on sharp curves, and chords a side of the former curves.
constexpr int face_samples = 3, side_samples = 4, chords_a_side = 16;

/// The sharp curves of a limit surface as chords.
class SharpCurves {
  public:
    explicit SharpCurves(const mesh::Cage& cage) {
        const auto sites = curve_sites(*cage.topology).sites;
        if (sites.empty()) return;
        const subd::LimitOperator ends(*cage.topology, closed_side_sets(chords_a_side), sites);
        ends.apply(cage.points, ends_);
        std::vector<geom::Box3> boxes;
        for (const auto row : ends.site_rows()) {
            if (row == ends.site_rows().back()) break;
            for (int k = 0; k < chords_a_side; ++k) {
                first_.push_back(row + k);
                boxes.emplace_back();
                boxes.back().add(ends_.row(row + k).transpose());
                boxes.back().add(ends_.row(row + k + 1).transpose());
            }
        }
        tree_ = geom::Bvh(boxes);
    }

    /// @pre there are curves
    [[nodiscard]] Vec3 nearest(const Vec3& query) const {
        Vec3 nearest = query;
        tree_.nearest(query, std::numeric_limits<double>::infinity(), [&](int i, double bound) {
            const Eigen::Index first = first_[std::size_t(i)];
            const Vec3 at = geom::nearest_on_segment(query, ends_.row(first).transpose(),
                                                     ends_.row(first + 1).transpose())
                                .point;
            const double distance = (query - at).norm();
            if (distance < bound) nearest = at;
            return std::min(bound, distance);
        });
        return nearest;
    }

  private:
    Points ends_;
    std::vector<Eigen::Index> first_;  ///< rows of ends_
    geom::Bvh tree_;
};

/// Samples of faces first, then of sides on sharp curves.
class Samples {
  public:
    explicit Samples(const Topology& topology)
        : Samples(topology, face_sites(topology), curve_sites(topology).sites) {}

    [[nodiscard]] const subd::LimitOperator& rows() const { return rows_; }

    /// How samples are to change, and how that counts.
    [[nodiscard]] std::pair<Points, SampleWeights> changes(const Points& points,
                                                           const mesh::Cage& former,
                                                           const measure::LimitSearch& search,
                                                           const SharpCurves& curves) const {
        Points limit;
        rows_.apply(points, limit);
        const auto feet = feet_of(limit, rows_.normals(points), former, search);
        std::pair<Points, SampleWeights> result{
            Points::Zero(limit.rows(), 3),
            {Points::Zero(limit.rows(), 3), Eigen::VectorXd::Ones(limit.rows())}};
        auto& [change, weights] = result;
        for (Eigen::Index i = 0; i < on_faces_; ++i) {
            const auto& foot = feet[std::size_t(i)];
            if (!foot) {
                weights.weight[i] = 0.0;
                continue;
            }
            weights.direction.row(i) = foot->normal.transpose();
            change.row(i) = foot->point.transpose() - limit.row(i);
        }
        for (Eigen::Index i = on_faces_; i < limit.rows(); ++i)
            change.row(i) = curves.nearest(limit.row(i).transpose()).transpose() - limit.row(i);
        return result;
    }

  private:
    /// For each sample of faces the nearest point of the former surface that faces alike, which
    /// one on the far side of a thin part does not. None where that is farther than any sample is
    /// whose nearest point of all faces alike: then the sample is in a fold (decision 089).
    [[nodiscard]] std::vector<std::optional<measure::NearLimit>> feet_of(
        const Points& limit, const Points& normals, const mesh::Cage& former,
        const measure::LimitSearch& search) const {
        const auto rows_of = [](const Points& all, const std::vector<Eigen::Index>& rows) {
            std::vector<Vec3> result;
            for (const Eigen::Index i : rows) result.emplace_back(all.row(i).transpose());
            return result;
        };
        std::vector<Eigen::Index> all(static_cast<std::size_t>(on_faces_)), opposing;
        std::iota(all.begin(), all.end(), 0);
        const auto nearest = search.nearest(former.points, rows_of(limit, all));
        std::vector<std::optional<measure::NearLimit>> result(nearest.size());
        double reach = 0.0;
        for (const Eigen::Index i : all) {
            const measure::NearLimit& near = nearest[std::size_t(i)];
            if (!measure::faces_alike(near.normal, normals.row(i).transpose())) {
                opposing.push_back(i);
                continue;
            }
            reach = std::max(reach, near.distance);
            result[std::size_t(i)] = near;
        }
        const auto alike =
            search.nearest(former.points, rows_of(limit, opposing), rows_of(normals, opposing));
        for (std::size_t k = 0; k < opposing.size(); ++k)
            if (alike[k].distance <= reach) result[std::size_t(opposing[k])] = alike[k];
        return result;
    }

    Samples(const Topology& topology, std::vector<subd::Site> faces,
            const std::vector<subd::Site>& sides)
        : rows_(topology, sets(), with(faces, sides), subd::SampleRows::PointsAndTangents),
          on_faces_(rows_.site_rows()[faces.size()]) {}

    static std::vector<subd::ParameterSet> sets() {
        std::vector<subd::ParameterSet> result{interior_grid(face_samples)};
        for (auto& set : side_sets(side_samples)) result.push_back(std::move(set));
        return result;
    }
    static std::vector<subd::Site> with(std::vector<subd::Site> faces,
                                        const std::vector<subd::Site>& sides) {
        for (subd::Site side : sides) {
            ++side.set;  // after that of faces
            faces.push_back(side);
        }
        return faces;
    }

    subd::LimitOperator rows_;
    Eigen::Index on_faces_;
};

}  // namespace

void return_to(mesh::Cage& cage, const mesh::Cage& former, const FitOptions& options) {
    const Topology& t = *cage.topology;
    const Samples samples(t);
    const measure::LimitSearch search(former.topology);
    const SharpCurves curves(former);
    // Whether or not the fit preserves the given parametrisation, spacing stays graded.
    const Regularisation regularisation = Regularisation::of_surface(
        t, cage.points, options.solver.tangential_scale_rel * options.tolerance_mm, true);
    const double share = double(samples.rows().rows()) / double(regularisation.rows().rows());
    PointConstraints pins{.held = std::vector<std::uint8_t>(std::size_t(t.vertex_count()), 0)};
    for (const mesh::VertexId v : t.vertices())
        if (t.is_pinned(v)) pins.held[v.index()] = PointConstraints::all;
    MeshPreconditioner preconditioner(t);
    StepWeights step_weights(cage.points.rows(), bending_weight);
    for (int i = 0; i < return_steps; ++i) {
        auto [change, weights] = samples.changes(cage.points, former, search, curves);
        weights.across = step_weights.tangential;
        const RegularisationWeights regular =
            regularisation.weights_at(cage.points, step_weights.fairness * share, share);
        const StepOperator step(samples.rows(), weights, regularisation.rows(), regular.rows,
                                step_weights.damping, pins);
        step.precondition(preconditioner);
        cage.points += step.displacements(
            solve_cgls(step, step.right_side(change, regularisation.changes(cage.points, regular)),
                       Points::Zero(step.columns(), 3),
                       {.max_iterations = options.solver.max_cgls_iterations,
                        .relative_residual = surface_residual,
                        .unknown_sizes = &step.scale(),
                        .preconditioner = &preconditioner,
                        .joint = true,
                        .progress = options.progress})
                .x);
        step_weights.after_taken();
    }
}

}  // namespace patchwright::fit
