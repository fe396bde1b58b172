// A walk along feature curves that keeps beside a chain from its first point to its last.
#pragma once

#include "fit/match/chain_matcher.h"

#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace patchwright::fit {

struct WalkOptions {
    geom::FeatureKind kind = geom::FeatureKind::Sharp;
    double length_cost_mm = 0.0;  ///< added to all distances: the shorter of two walks costs less
    double coincidence_mm = 0.0;  ///< stops belong to curves that are nearer than this
    double reach_mm = 0.0;        ///< walks that are farther on average are not looked for
    std::function<void()> poll = [] {};  ///< called while walks are looked for; may throw
};

/// Walks go forward, never back, while the chain is followed from point to point. They cost the
/// distances of the chain's points from the steps beside them and of the steps from the chain's
/// edges beside them, times lengths: chain and walk keep together, wherever else the curves come
/// near. Map matching, after Newson and Krumm, Hidden Markov map matching through noise and
/// sparseness (2009); the walk of least cost is a shortest path in the product of points and steps.
class CurveWalk {
  public:
    /// @pre `reference` and `curve_ends` outlive it
    CurveWalk(const geom::ReferenceSurface& reference, const geom::CurveEnds& curve_ends,
              const WalkOptions& options, const Polyline& line);

    /// From stop to stop; empty where there is none.
    FeaturePath between(const std::array<Stop, 2>& stops);
    /// Once round; the chain's last point is its first.
    FeaturePath round();

    /// Mean distance of the chain's points from the walk found last; millimetres.
    [[nodiscard]] double mean_distance() const { return mean_distance_; }

  private:
    /// A curve in steps: step k runs from arc[k] to arc[k + 1].
    struct Steps {
        std::vector<double> arc;
        std::vector<std::optional<geom::Vec3>> point;  ///< once it was asked for
        std::vector<int> junction;                     ///< of a point; -1: none
    };
    /// A point within a curve at which it is divided besides.
    struct Division {
        int curve;
        double arc;
        int junction;
    };
    struct Move {
        int curve, step;
        bool reversed;
    };

    struct Walk {
        std::vector<int> moves;
        double cost = std::numeric_limits<double>::infinity();
        double mean_distance = 0.0;
    };

    /// See kind_mismatch_penalty().
    [[nodiscard]] double penalty(int curve) const;
    /// Divides the curves that the stop lies on there, unless it is a corner.
    void add_stop(const Stop& stop, int junction);
    void number_steps();
    /// Of a curve, once they are asked for: walks come near few curves of a model.
    Steps& steps(int curve);
    [[nodiscard]] int count(int curve) const;
    [[nodiscard]] std::vector<int> leaving(int junction);
    [[nodiscard]] Move move(int number) const;
    [[nodiscard]] int number(const Move& m) const;
    /// The point that a move ends at, as a number among those of its curve.
    [[nodiscard]] static int end_of(const Move& m) { return m.reversed ? m.step : m.step + 1; }
    [[nodiscard]] double length_of(const Move& m);
    [[nodiscard]] const geom::Vec3& point(int curve, int k);
    [[nodiscard]] std::vector<int> moves_after(int number);
    [[nodiscard]] double distance_to_move(int number, const geom::Vec3& q);
    /// Of the chain's point to the step, times the length that it stands for.
    [[nodiscard]] double point_cost(std::size_t i, int number);
    /// Of going on to the next step while the chain is between this point and the next.
    [[nodiscard]] double step_cost(std::size_t i, int from, int to);
    /// Where a closed walk may begin.
    [[nodiscard]] std::vector<int> first_moves();
    /// The cheapest walk below a cost from one of the first moves to one of the last ones.
    Walk cheapest(const std::vector<int>& first, const std::vector<int>& last, double limit);
    [[nodiscard]] FeaturePath path_of(const std::vector<int>& moves);

    const geom::ReferenceSurface& reference_;
    const geom::Features& features_;
    const geom::CurveEnds& curve_ends_;
    WalkOptions options_;
    const Polyline& line_;
    std::vector<double> share_;  // the length that each point of the chain stands for
    std::vector<Division> divisions_;
    std::vector<int> first_;  // step of each curve; moves are twice a step's number, and 1 more
    std::vector<int> slot_;   // of each curve in steps_; -1: not yet asked for
    std::deque<Steps> steps_;
    double mean_distance_ = 0.0;
};

}  // namespace patchwright::fit
