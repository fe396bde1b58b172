// A walk along feature curves that keeps beside a chain from its first point to its last.
#pragma once

#include "fit/match/chain_matcher.h"

#include <limits>
#include <optional>
#include <vector>

namespace patchwright::fit {

struct WalkOptions {
    geom::FeatureKind kind = geom::FeatureKind::Sharp;
    double length_cost_mm = 0.0;  ///< added to all distances: the shorter of two walks costs less
    double coincidence_mm = 0.0;  ///< stops belong to curves that are nearer than this
    double reach_mm = 0.0;        ///< walks that are farther on average are not looked for
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
        double penalty = 0.0;                          ///< see kind_mismatch_penalty()
        int first = 0;  ///< number of step 0, forwards; it has first + 1 backwards
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

    void divide();
    /// Divides the curves that the stop lies on there, unless it is a corner.
    void add_stop(const Stop& stop, int junction);
    void join();
    [[nodiscard]] Move move(int number) const;
    [[nodiscard]] int number(const Move& m) const;
    /// The point that a move ends at, as a number among those of its curve.
    [[nodiscard]] static int end_of(const Move& m) { return m.reversed ? m.step : m.step + 1; }
    [[nodiscard]] double length_of(const Move& m) const;
    [[nodiscard]] const geom::Vec3& point(int curve, int k);
    [[nodiscard]] std::vector<int> moves_after(int number) const;
    [[nodiscard]] double distance_to_move(int number, const geom::Vec3& q);
    /// Of the chain's point to the step, times the length that it stands for.
    [[nodiscard]] double point_cost(std::size_t i, int number);
    /// Of going on to the next step while the chain is between this point and the next.
    [[nodiscard]] double step_cost(std::size_t i, int from, int to);
    /// Where a closed walk may begin.
    [[nodiscard]] std::vector<int> first_moves();
    /// The cheapest walk below a cost from one of the first moves to one of the last ones.
    Walk cheapest(const std::vector<int>& first, const std::vector<int>& last, double limit);
    [[nodiscard]] FeaturePath path_of(const std::vector<int>& moves) const;

    const geom::ReferenceSurface& reference_;
    const geom::Features& features_;
    const geom::CurveEnds& curve_ends_;
    WalkOptions options_;
    const Polyline& line_;
    std::vector<double> share_;  // the length that each point of the chain stands for
    std::vector<Steps> curves_;
    std::vector<int> curve_of_;              // by move / 2
    std::vector<std::vector<int>> leaving_;  // moves, by junction
    double mean_distance_ = 0.0;
};

}  // namespace patchwright::fit
