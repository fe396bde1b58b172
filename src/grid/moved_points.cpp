#include "grid/moved_points.h"

#include "grid/cell_point.h"
#include "grid/limit_face.h"

#include <patchwright/base/parallel.h>

#include <unordered_map>

namespace patchwright::grid {

namespace {

/// Enough to make up for the pieces that a task builds.
constexpr std::size_t moved_points_a_task = 8192;

}  // namespace

void evaluate_moved(const Plan& plan, int block, subd::RingTable& table, BlockPoints& points) {
    const std::vector<subd::Location>& places = plan.moved.at(std::size_t(block));
    const auto [ni, nj] = plan.size(block);
    points.ni = ni;
    points.nj = nj;
    points.nk = 1;
    for (auto& c : points.coordinates) c.resize(points.count());
    base::parallel_for(
        places.size(), moved_points_a_task, [&](std::size_t first, std::size_t last) {
            std::unordered_map<std::int32_t, LimitFace> faces;
            for (std::size_t n = first; n < last; ++n) {
                const subd::Location& at = places[n];
                auto face = faces.find(at.face.value);
                if (face == faces.end())
                    face = faces.try_emplace(at.face.value, table, plan.layout.cage, at.face).first;
                points.set(n, face->second.at(at.u, at.v));
            }
        });
}

void evaluate_moved_edges(Plan& plan) {
    subd::RingTable table;
    BlockPoints points;
    for (std::size_t b = 0; b < plan.layout.blocks.size(); ++b) {
        evaluate_moved(plan, int(b), table, points);
        for (int side = 0; side < 4; ++side) {
            int begin = 0;
            for (const BlockEdgeUse& use : plan.layout.blocks[b].sides[std::size_t(side)]) {
                EdgePoints& edge = plan.edges[std::size_t(use.edge)];
                const int cells = edge.cells();
                for (int k = 0; k <= cells; ++k) {
                    const auto [i, j] = on_side({points.ni, points.nj}, side, begin + k);
                    edge.points.row(use.reversed ? cells - k : k) = points.at(i, j);
                }
                begin += cells;
            }
        }
    }
    for (EdgePoints& edge : plan.edges) {
        edge.length_mm = 0.0;
        for (int k = 0; k < edge.cells(); ++k)
            edge.length_mm += (edge.points.row(k + 1) - edge.points.row(k)).norm();
    }
}

}  // namespace patchwright::grid
