// Where the grid lines of blocks run: coordinates over all blocks at once.
#pragma once

#include "cage/blocks/block_layout.h"
#include "cage/blocks/divisions.h"
#include "cage/field/size_metric.h"
#include "cage/poll.h"

#include <memory>

namespace patchwright::cage {

/// Two coordinates on the triangles of all blocks, whole numbers along grid lines. Across an arc
/// inside the surface they go on as those of the block beyond, so that arcs are none of their
/// lines: only features are, on which points may slide, and singular nodes stay. Between nodes that
/// stay the points of a feature are where LayoutArc::shares put them. Of all such coordinates these
/// have the least Dirichlet energy in the metric, so that lines are near where edges are to be
/// short.
/// @pre every block is a whole piece, and its opposite sides have equal numbers of edges
/// @throw LayoutRefused when there are no such coordinates
///
/// Source: Campen, Bommes and Kobbelt, Quantized global parametrization (2015), with Dirichlet's
/// energy in place of the field.
class BlockMap {
  public:
    /// All are kept by reference.
    BlockMap(const QuadLayout& layout, const Divisions& divisions, const SizeMetric& metric,
             Poll& poll);
    ~BlockMap();
    BlockMap(BlockMap&&) noexcept;
    BlockMap& operator=(BlockMap&&) noexcept;

    /// The point of a block with given coordinates, from 0 to the numbers of edges of its first and
    /// second side.
    [[nodiscard]] FlatPiece::SurfacePoint point(int block, const Vec2& p) const;
    /// Points along an arc at whole numbers of its edges.
    [[nodiscard]] std::vector<geom::Vec3> along(int arc) const;

  private:
    class Solver;
    std::unique_ptr<Solver> solver_;
};

}  // namespace patchwright::cage
