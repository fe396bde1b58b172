// Pairs of pieces of surfaces, halved until they are settled.
#pragma once

#include "measure/surface_pieces.h"

#include <functional>
#include <map>
#include <memory>
#include <vector>

namespace patchwright::measure {

struct PairTask {
    std::array<int, 2> surfaces;  ///< the same one twice: whether it meets itself
    SurfacePieces::Pair pieces;
};

/// All pairs that are left are tested, then what is not settled is halved: a surface that is folded
/// all over is found out before its smallest parts are looked into.
class PairSearch {
  public:
    using Surfaces = std::vector<std::unique_ptr<SurfacePieces>>;
    using Found = std::map<std::array<int, 2>, SelfIntersection>;

    PairSearch(const Surfaces& surfaces, std::vector<PairTask> tasks, double resolution)
        : surfaces_(surfaces), tasks_(std::move(tasks)), resolution_(resolution) {}

    /// @param tests_left  of further searches too; what is left when there are no more is not
    ///        excluded
    /// @return by surfaces
    Found run(std::size_t& tests_left, const std::function<void()>& check_progress);

  private:
    [[nodiscard]] SurfacePieces::Outcome test(const PairTask& task) const;
    void test_all(const std::function<void()>& check_progress);
    void halve();
    [[nodiscard]] SelfIntersection doubt_at(const PairTask& task) const;

    const Surfaces& surfaces_;
    std::vector<PairTask> tasks_;
    double resolution_;
    std::vector<SurfacePieces::Next> next_;  ///< of each task
    Found found_;
};

}  // namespace patchwright::measure
