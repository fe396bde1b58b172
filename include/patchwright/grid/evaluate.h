// The points of a block.
#pragma once

#include <patchwright/grid/plan.h>

#include <memory>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::grid {

/// Points of one block, coordinates apart, as most formats want them; those of (i, j, k) are entry
/// i + ni (j + nj k). Surfaces have one layer.
struct BlockPoints {
    int ni = 0, nj = 0, nk = 1;
    std::array<std::vector<double>, 3> coordinates;

    [[nodiscard]] std::size_t count() const {
        return std::size_t(ni) * std::size_t(nj) * std::size_t(nk);
    }
    [[nodiscard]] std::size_t index(int i, int j, int k = 0) const {
        return std::size_t(i) +
               std::size_t(ni) * (std::size_t(j) + std::size_t(nj) * std::size_t(k));
    }
    [[nodiscard]] geom::Vec3 at(int i, int j, int k = 0) const {
        const std::size_t n = index(i, j, k);
        return {coordinates[0][n], coordinates[1][n], coordinates[2][n]};
    }
    void set(std::size_t n, const geom::Vec3& p) {
        for (std::size_t c = 0; c < 3; ++c) coordinates[c][n] = p[Eigen::Index(c)];
    }
};

/// Places of a block's points on the given cage, as those of subd::Location, in the order of
/// BlockPoints with one layer; further layers grow from there.
struct BlockPlaces {
    std::vector<std::int32_t> faces;
    std::vector<double> u, v;
    std::vector<std::int32_t> sectors;  ///< empty where the given cage has quads only
};

/// Evaluates blocks of a plan, each with all threads. Points on the sides are the plan's, bit by
/// bit; those of a smoothed plan are all at their places. Else inner points are limit points at
/// parameters blended from those of the four sides, where the line between the points of equal j on
/// sides 3 and 1 meets the line between those of equal i. Source: Soni, Two- and three-dimensional
/// grid generation for internal flow applications (1985), boundary-blended control functions; here
/// in the parameters of the limit surface.
class BlockEvaluator {
  public:
    /// @pre the plan outlives this
    explicit BlockEvaluator(const Plan& plan);
    ~BlockEvaluator();
    BlockEvaluator(const BlockEvaluator&) = delete;
    BlockEvaluator& operator=(const BlockEvaluator&) = delete;

    /// @throw InvalidArgument when there is no such block
    [[nodiscard]] BlockPoints evaluate(int block) const;
    /// The same into buffers that are used again.
    void evaluate(int block, BlockPoints& points) const;
    void places(int block, BlockPlaces& places) const;
    /// Parameters of a block's point, i-wise in [0, columns] and j-wise in [0, rows].
    /// @throw InvalidArgument where the plan is smoothed
    [[nodiscard]] Eigen::Vector2d parameters(int block, int i, int j) const;
    /// Of all its points, in the order of BlockPoints.
    [[nodiscard]] std::vector<Eigen::Vector2d> parameters(int block) const;

  private:
    struct State;
    const Plan& plan_;
    std::unique_ptr<State> state_;
};

}  // namespace patchwright::grid
#pragma GCC visibility pop
