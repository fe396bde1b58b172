#include "fit/loop/refinement.h"

#include "fit/loop/former_surface.h"
#include "fit/loop/spacing.h"
#include "fit/solve/step_operator.h"

#include <patchwright/mesh/chords.h>
#include <patchwright/subd/refine.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::fit {

namespace {

using mesh::FaceId;
using mesh::Topology;

// A direction is too coarse when it has at least this share of the changes along both: a residual
// that changes along one direction only is not split along the other.
constexpr double coarse_share = 0.2;
// A face is not split again after this many splits in a row that gained too little: what is left
// is a feature that the cage lacks (refinement_test: faces that gain nothing).
constexpr int max_useless_splits = 5;
// Of its parent's distance: a face with more than this left gained too little from the split.
// Splits of smooth regions leave a sixteenth to a quarter.
constexpr double max_remaining_error = 0.6;
// Splitting all faces leaves the limit surface as it is; when local refinement would split more
// than this share of the edges, that is worth more than the faces saved.
constexpr double max_local_share = 0.7;
// Weight of the bending energy of the change when limit points are fitted to the coarse surface:
// makes the problem regular without moving them.
constexpr double split_bending = 1e-3;

/// Bits as in ChordSplit::cuts.
int wanted_cuts(const FaceError& error, double tolerance) {
    if (error.folded > 0) return 3;
    int cuts = (error.curve_u > tolerance ? 1 : 0) + (error.curve_v > tolerance ? 2 : 0);
    if (std::max(error.max, error.reverse) > tolerance) {
        const double both = error.change_u + error.change_v;
        if (error.change_u >= coarse_share * both) cuts |= 1;
        if (error.change_v >= coarse_share * both) cuts |= 2;
    }
    return cuts;
}

/// A feature of the reference that is beyond the tolerance from a face whose own samples are less
/// than half as far from the reference: it is narrower than the distance between these samples.
struct UnresolvedFeature {
    FaceId face;
    Eigen::Vector2d at;  ///< parameters in the face
    int cuts = 0;        ///< directions in which it is narrow, as in ChordSplit::cuts
    double size = 0.0;   ///< its distance, millimetres
};

// Samples that are at least this share as far from the reference as the feature resolve it.
constexpr double resolved_share = 0.5;
// A feature is narrow along a direction in which it is less than this many times as wide as high;
// strips are halved until they are no wider than that (refinement_test: strips get as narrow).
constexpr double narrow_ratio = 4.0;
constexpr int min_beyond = 3;  // points beyond the tolerance that tell how wide it is

/// Widths of a face's control polygon along u and along v.
std::array<double, 2> widths(const mesh::Cage& cage, FaceId f) {
    const auto corners = cage.topology->corners(f);
    const auto length = [&](int i) {
        return (cage.points.row(cage.topology->vertex(corners[(i + 1) % 4]).value) -
                cage.points.row(cage.topology->vertex(corners[i]).value))
            .norm();
    };
    return {0.5 * (length(0) + length(2)), 0.5 * (length(1) + length(3))};
}

std::vector<UnresolvedFeature> unresolved_features(const mesh::Cage& cage,
                                                   const LevelError& error) {
    std::vector<UnresolvedFeature> features;
    for (const FaceId f : cage.topology->faces()) {
        const FaceError& face = error.faces[f.index()];
        if (face.max > resolved_share * face.reverse || face.beyond_count < min_beyond) continue;
        const auto width = widths(cage, f);
        UnresolvedFeature feature{f, face.reverse_at, 0, face.reverse};
        for (int i = 0; i < 2; ++i)
            if (face.beyond.sizes()[i] * width[std::size_t(i)] < narrow_ratio * face.reverse)
                feature.cuts |= 1 << i;
        if (feature.cuts != 0) features.push_back(feature);
    }
    return features;
}

std::vector<FaceHistory> inherit(const std::vector<FaceId>& parents, const std::vector<int>& cuts,
                                 const LevelError& error, const std::vector<FaceHistory>& history) {
    std::vector<FaceHistory> result;
    for (const FaceId parent : parents) {
        const int cut = cuts[parent.index()];
        if (cut == 0) {
            result.push_back(history[parent.index()]);
            continue;
        }
        const FaceHistory& old = history[parent.index()];
        const FaceError& of_parent = error.faces[parent.index()];
        result.push_back(
            {of_parent.largest(), old.cuts + (cut == 3 ? 2 : 1), of_parent.folded > 0});
    }
    return result;
}

NextLevel refine_everywhere(const mesh::Cage& cage, const LevelError& error,
                            const std::vector<FaceHistory>& history) {
    NextLevel next;
    next.cage = subd::refine(cage, 1);
    std::vector<FaceId> parents;
    for (const FaceId f : cage.topology->faces()) {
        parents.insert(parents.end(), std::size_t(cage.topology->size(f)), f);
    }
    next.history = inherit(parents, std::vector<int>(error.faces.size(), 3), error, history);
    return next;
}

// Of a face's children in the order in which they are made, in u and in v.
constexpr std::array<std::array<int, 2>, 4> quarters{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

/// Limit points of the old cage where the samples of the new one's faces come from.
geom::Points former_limit(const mesh::Cage& cage, const mesh::ChordSplit& fine,
                          const subd::ParameterSet& set) {
    const subd::LimitEvaluator evaluator(cage.topology);
    geom::Points limit(Eigen::Index(fine.parents.size() * set.size()), 3);
    Eigen::Index row = 0;
    int child = 0;
    for (std::size_t f = 0; f < fine.parents.size(); ++f) {
        const FaceId parent = fine.parents[f];
        child = f > 0 && fine.parents[f - 1] == parent ? child + 1 : 0;
        const int cuts = fine.cuts[parent.index()];
        const auto& quarter = quarters[std::size_t(child)];
        const double u0 = cuts == 1 ? child : quarter[0], v0 = cuts == 2 ? child : quarter[1];
        for (const Eigen::Vector2d& at : set) {
            const double u = (cuts & 1) != 0 ? 0.5 * (u0 + at.x()) : at.x();
            const double v = (cuts & 2) != 0 ? 0.5 * (v0 + at.y()) : at.y();
            limit.row(row++) = evaluator.position(cage.points, {parent, u, v}).transpose();
        }
    }
    return limit;
}

/// Moves features to the children of their faces.
void pass_on(std::vector<UnresolvedFeature>& features, const mesh::ChordSplit& fine) {
    std::vector<int> first_child(fine.cuts.size(), -1);
    for (std::size_t f = fine.parents.size(); f-- > 0;)
        first_child[fine.parents[f].index()] = int(f);
    for (UnresolvedFeature& feature : features) {
        const int cuts = fine.cuts[feature.face.index()];
        std::array<int, 2> half{0, 0};
        for (int i = 0; i < 2; ++i) {
            if ((cuts >> i & 1) == 0) continue;
            half[std::size_t(i)] = feature.at[i] < 0.5 ? 0 : 1;
            feature.at[i] = 2.0 * feature.at[i] - half[std::size_t(i)];
        }
        const auto quarter = std::find(quarters.begin(), quarters.end(), half) - quarters.begin();
        feature.face = FaceId{first_child[feature.face.index()] +
                              (cuts == 3 ? int(quarter) : std::max(half[0], half[1]))};
    }
}

/// The cage with strips split, its limit surface near that of the given one.
mesh::Cage split_strips(const mesh::Cage& cage, const mesh::ChordSplit& fine,
                        const base::Progress& progress) {
    const Topology& t = *cage.topology;
    mesh::Cage next;
    next.topology = fine.topology;
    next.points.resize(fine.topology->vertex_count(), 3);
    for (Eigen::Index v = 0; v < next.points.rows(); ++v) {
        const auto& at = fine.vertices[std::size_t(v)];
        const auto corners = t.corners(at.face);
        const std::array<double, 4> weight{(1 - at.u) * (1 - at.v), at.u * (1 - at.v), at.u * at.v,
                                           (1 - at.u) * at.v};
        next.points.row(v).setZero();
        for (int i = 0; i < 4; ++i) {
            next.points.row(v) +=
                weight[std::size_t(i)] * cage.points.row(t.vertex(corners[i]).value);
        }
    }
    // Least squares at equal parameters brings it back to the coarse limit surface.
    const auto set = interior_grid(3);
    const auto sites = face_sites(*fine.topology);
    const subd::LimitOperator samples(*fine.topology, {set}, sites);
    const subd::LimitOperator bending(*fine.topology, {interior_grid(2)}, sites,
                                      subd::SampleRows::Bending);
    PointConstraints pins{.held = std::vector<std::uint8_t>(fine.vertices.size(), 0)};
    for (const mesh::VertexId v : t.vertices()) {
        if (t.is_pinned(v)) pins.held[v.index()] = PointConstraints::all;
    }
    geom::Points limit;
    samples.apply(next.points, limit);
    const geom::Points change = former_limit(cage, fine, set) - limit;
    const SampleWeights weights{geom::Points::Zero(change.rows(), 3),
                                Eigen::VectorXd::Ones(change.rows())};
    const SampleWeights stiff{.direction = geom::Points::Zero(bending.rows(), 3),
                              .weight = Eigen::VectorXd::Ones(bending.rows()),
                              .without = std::sqrt(split_bending)};
    const StepOperator step(samples, weights, bending, stiff,
                            Eigen::VectorXd::Zero(next.points.rows()), pins);
    next.points += step.displacements(
        solve_cgls(
            step, step.right_side(change, geom::Points::Zero(bending.rows(), 3)),
            geom::Points::Zero(step.columns(), 3),
            {.max_iterations = 100, .relative_residual = 1e-4, .joint = true, .progress = progress})
            .x);
    return next;
}

/// How often a face has been halved in u and in v.
using Halvings = std::array<int, 2>;

std::vector<Halvings> after_split(const mesh::ChordSplit& fine,
                                  const std::vector<Halvings>& before) {
    std::vector<Halvings> result;
    for (const FaceId parent : fine.parents) {
        const int cuts = fine.cuts[parent.index()];
        const auto& [u, v] = before[parent.index()];
        result.push_back({u + (cuts & 1), v + (cuts >> 1)});
    }
    return result;
}

std::vector<int> by_edge(const Topology& t, const std::vector<Halvings>& of_faces) {
    std::vector<int> result(std::size_t(t.edge_count()), 0);
    for (const FaceId f : t.faces())
        for (int i = 0; i < 4; ++i)
            result[t.edge(t.corners(f)[i]).index()] = of_faces[f.index()][std::size_t(i % 2)];
    return result;
}

bool is_too_large(const Topology& t, const FitOptions& options, double most_faces) {
    return t.vertex_count() > options.max_vertices || t.face_count() > most_faces;
}

/// Halves strips at unresolved features until they are about as wide as these, or the cage would
/// grow beyond its bounds.
/// @param halvings  of the faces, brought up to date
void split_at_unresolved(NextLevel& next, std::vector<Halvings>& halvings,
                         std::vector<UnresolvedFeature> features, const FitOptions& options,
                         double most_faces) {
    for (;;) {
        const Topology& t = *next.cage.topology;
        const mesh::Chords chords = mesh::find_chords(t);
        std::vector<char> chosen(std::size_t(chords.count), 0);
        bool any = false;
        for (const UnresolvedFeature& feature : features) {
            const auto width = widths(next.cage, feature.face);
            for (int i = 0; i < 2; ++i) {
                if ((feature.cuts >> i & 1) == 0 ||
                    width[std::size_t(i)] <= narrow_ratio * feature.size)
                    continue;
                const mesh::EdgeId side = t.edge(t.corners(feature.face)[i]);
                chosen[std::size_t(chords.of_edge[side.index()])] = 1;
                any = true;
            }
        }
        if (!any) return;
        const mesh::ChordSplit fine = split_chords(t, chords, chosen);
        if (is_too_large(*fine.topology, options, most_faces)) return;
        std::vector<FaceHistory> history;
        for (const FaceId parent : fine.parents) history.push_back(next.history[parent.index()]);
        halvings = after_split(fine, halvings);
        next.cage = split_strips(next.cage, fine, options.progress);
        next.history = std::move(history);
        pass_on(features, fine);
    }
}

}  // namespace

std::optional<NextLevel> refine_where_needed(const mesh::Cage& cage, const LevelError& error,
                                             std::vector<FaceHistory> history,
                                             const FitOptions& options, RefinementScope refinement,
                                             double most_faces) {
    const Topology& t = *cage.topology;
    history.resize(error.faces.size());
    std::vector<int> cuts(error.faces.size(), 0);
    int wanting = 0;
    for (std::size_t f = 0; f < cuts.size(); ++f) {
        const double now = error.faces[f].largest();
        if (now <= max_remaining_error * history[f].parent) history[f].cuts = 0;
        if (now <= options.tolerance_mm && error.faces[f].folded == 0) continue;
        if (history[f].cuts >= max_useless_splits) continue;
        cuts[f] = wanted_cuts(error.faces[f], options.tolerance_mm);
        ++wanting;
    }
    if (wanting == 0) return std::nullopt;
    if (refinement == RefinementScope::Local && t.all_quads()) {
        const mesh::Chords chords = mesh::find_chords(t);
        std::vector<char> chosen(std::size_t(chords.count), 0);
        for (const FaceId f : t.faces()) {
            for (int i = 0; i < 2; ++i) {
                if ((cuts[f.index()] >> i & 1) == 0) continue;
                chosen[std::size_t(chords.of_edge[t.edge(t.corners(f)[i]).index()])] = 1;
            }
        }
        const auto edges = std::count_if(chords.of_edge.begin(), chords.of_edge.end(),
                                         [&](int c) { return chosen[std::size_t(c)] != 0; });
        if (double(edges) < max_local_share * t.edge_count()) {
            const mesh::ChordSplit fine = split_chords(t, chords, chosen);
            if (is_too_large(*fine.topology, options, most_faces)) return std::nullopt;
            NextLevel next{.cage = split_strips(cage, fine, options.progress),
                           .history = inherit(fine.parents, fine.cuts, error, history),
                           .local = true};
            std::vector<UnresolvedFeature> features = unresolved_features(cage, error);
            pass_on(features, fine);
            auto halvings = after_split(fine, std::vector<Halvings>(cuts.size(), {0, 0}));
            split_at_unresolved(next, halvings, std::move(features), options, most_faces);
            grade_spacing(next.cage, by_edge(*next.cage.topology, halvings), error.at_turns);
            return_to(next.cage, cage, options);
            return next;
        }
    }
    if (wanting < options.min_share_to_split_all * double(cuts.size()) ||
        4 * t.vertex_count() > options.max_vertices || 4.0 * t.face_count() > most_faces)
        return std::nullopt;
    return refine_everywhere(cage, error, history);
}

}  // namespace patchwright::fit
