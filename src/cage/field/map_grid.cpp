#include "cage/field/map_grid.h"

#include "cage/blocks/corner_rings.h"
#include "cage/blocks/layout_refused.h"
#include "cage/blocks/shape_quads.h"
#include "cage/field/block_map.h"
#include "cage/field/grid_vertices.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <map>
#include <utility>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

class MapGrid {
  public:
    MapGrid(const QuadLayout& layout, const Divisions& divisions, const SizeMetric& metric,
            const geom::ModelSurface& reference, Poll& poll)
        : layout_(layout),
          reference_(reference),
          poll_(poll),
          map_(layout, divisions, metric, poll),
          vertices_(grid_vertices(layout, divisions)) {}

    BlocksOnCurves make() {
        blocks_.points.resize(at(vertices_.count));
        freedom_.resize(at(vertices_.count));
        placed_.assign(at(vertices_.count), 0);
        add_nodes();
        for (std::size_t a = 0; a < layout_.arcs.size(); ++a) add_arc(int(a));
        for (std::size_t b = 0; b < layout_.blocks.size(); ++b) add_block(int(b));
        check();
        const QuadsOnModel quads{blocks_.faces, freedom_, blocks_.creases, normals_};
        shape_quads(quads, blocks_.points, reference_, poll_);
        even_corner_rings(quads, blocks_.points, reference_, poll_);
        return {std::move(blocks_), std::move(curves_)};
    }

  private:
    void place(int v, const Vec3& p) {
        blocks_.points[at(v)] = p;
        placed_[at(v)] = 1;
    }

    /// Nodes that stay; for the others which feature they are on.
    void add_nodes() {
        for (std::size_t i = 0; i < layout_.nodes.size(); ++i) {
            const LayoutNode& node = layout_.nodes[i];
            const int v = vertices_.of_node[i];
            if (node.corner) blocks_.corners.push_back(v);
            if (placed_[at(v)] != 0) continue;
            if (node.corner || (node.held && node.curve < 0)) {
                freedom_[at(v)] = {false, -1};
                place(v, node.point);
            } else if (node.held) {
                freedom_[at(v)] = {false, node.curve};
            }
        }
    }

    void add_arc(int a) {
        const LayoutArc& arc = layout_.arcs[at(a)];
        const std::vector<int>& line = vertices_.of_arc[at(a)];
        if (line.size() == 1) return;
        const std::vector<Vec3> points = map_.along(a);
        for (std::size_t k = 0; k < line.size(); ++k) {
            poll_();
            Freedom& freedom = freedom_[at(line[k])];
            // On a feature a point is where the feature's own coordinates put it.
            if (arc.curve >= 0 && freedom.free) {
                freedom = {false, arc.curve};
                placed_[at(line[k])] = 0;
            }
            if (placed_[at(line[k])] != 0) continue;
            if (arc.curve >= 0)
                place(line[k], reference_.nearest_on_curve(arc.curve, points[k]).point);
            else if (freedom.free)
                place(line[k], reference_.foot_point(points[k]).point);
        }
        for (std::size_t k = 0; k + 1 < line.size(); ++k) {
            if (arc.curve >= 0) curves_[std::minmax(line[k], line[k + 1])] = arc.curve;
            if (arc.crease) blocks_.creases.emplace_back(line[k], line[k + 1]);
        }
    }

    int add_point(const Vec3& p) {
        blocks_.points.push_back(p);
        freedom_.emplace_back();
        return int(blocks_.points.size()) - 1;
    }

    void add_block(int b) {
        const LayoutBlock& block = layout_.blocks[at(b)];
        const std::vector<int> bottom = vertices_.along(block.sides[0]),
                               right = vertices_.along(block.sides[1]);
        std::vector<int> top = vertices_.along(block.sides[2]),
                         left = vertices_.along(block.sides[3]);
        std::reverse(top.begin(), top.end());
        std::reverse(left.begin(), left.end());
        if (bottom.size() != top.size() || left.size() != right.size())
            throw LayoutRefused{"sides of a block do not meet"};
        const int m = int(bottom.size()) - 1, n = int(left.size()) - 1;
        if (m == 0 || n == 0) return;
        std::vector<std::vector<int>> grid{bottom};
        for (int j = 1; j < n; ++j) {
            grid.push_back({left[at(j)]});
            for (int i = 1; i < m; ++i) {
                const FlatPiece::SurfacePoint p = map_.point(b, Vec2(i, j));
                grid.back().push_back(add_point(reference_.foot_point(p.point, p.normal).point));
            }
            grid.back().push_back(right[at(j)]);
        }
        grid.push_back(top);
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < m; ++i) {
                blocks_.faces.push_back({grid[at(j)][at(i)], grid[at(j)][at(i + 1)],
                                         grid[at(j + 1)][at(i + 1)], grid[at(j + 1)][at(i)]});
                normals_.push_back(map_.point(b, Vec2(i + 0.5, j + 0.5)).normal);
            }
    }

    /// Where blocks have no width others may share two edges, which is right at corners only.
    void check() const {
        std::map<std::pair<int, int>, int> faces_of;
        std::map<int, int> around;
        for (const auto& face : blocks_.faces) {
            for (std::size_t k = 0; k < 4; ++k) {
                if (++faces_of[std::minmax(face[k], face[(k + 1) % 4])] > 2)
                    throw LayoutRefused{"three quads share an edge"};
                ++around[face[k]];
            }
        }
        for (const auto& [edge, count] : faces_of)
            if (count == 1) around[edge.first] = around[edge.second] = 4;  // of the border
        for (const auto& [vertex, count] : around)
            if (count < 3 && (freedom_[at(vertex)].free || freedom_[at(vertex)].curve >= 0))
                throw LayoutRefused{"two quads share two edges"};
    }

    const QuadLayout& layout_;
    const geom::ModelSurface& reference_;
    Poll& poll_;
    BlockMap map_;
    GridVertices vertices_;
    Blocks blocks_;
    std::vector<Freedom> freedom_;
    std::vector<char> placed_;
    std::vector<Vec3> normals_;  ///< of the model, one a face
    EdgeCurves curves_;
};

}  // namespace

BlocksOnCurves map_grid(const QuadLayout& layout, const Divisions& divisions,
                        const SizeMetric& metric, const geom::ModelSurface& reference, Poll& poll) {
    return MapGrid(layout, divisions, metric, reference, poll).make();
}

}  // namespace patchwright::cage
