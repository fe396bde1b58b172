// Where writers and measures get the blocks of a grid from, one at a time.
#pragma once

#include <patchwright/grid/evaluate.h>

#pragma GCC visibility push(default)
namespace patchwright::grid {

/// A surface or a volume grid. Its blocks are those of a layout, with layers k on top of (i, j).
class BlockSource {
  public:
    virtual ~BlockSource() = default;

    [[nodiscard]] virtual const Plan& plan() const = 0;
    [[nodiscard]] virtual int layers() const = 0;  ///< points along k: 1 for surfaces
    /// Whether the last layer lies on a sphere far off.
    [[nodiscard]] virtual bool has_far_field() const { return false; }
    /// Fills the points of a block, with all threads.
    virtual void evaluate(int block, BlockPoints& points) const = 0;

    [[nodiscard]] int block_count() const { return static_cast<int>(plan().layout.blocks.size()); }
    [[nodiscard]] std::array<int, 3> size(int block) const {
        const auto [ni, nj] = plan().size(block);
        return {ni, nj, layers()};
    }
};

/// The grid of a plan on the limit surface itself.
class SurfaceGrid : public BlockSource {
  public:
    /// @pre the plan outlives this
    explicit SurfaceGrid(const Plan& plan) : plan_(plan), evaluator_(plan) {}

    [[nodiscard]] const Plan& plan() const override { return plan_; }
    [[nodiscard]] int layers() const override { return 1; }
    void evaluate(int block, BlockPoints& points) const override {
        evaluator_.evaluate(block, points);
    }

  private:
    const Plan& plan_;
    BlockEvaluator evaluator_;
};

}  // namespace patchwright::grid
#pragma GCC visibility pop
