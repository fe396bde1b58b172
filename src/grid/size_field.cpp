#include "geom/bvh.h"
#include "grid/memory.h"

#include <patchwright/base/error.h>
#include <patchwright/grid/size_field.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::grid {

struct SizeField::State {
    geom::Points at;
    std::vector<double> sizes;
    geom::Bvh tree;
};

SizeField::SizeField(geom::Points at, std::vector<double> sizes_mm) {
    if (sizes_mm.empty() || at.rows() != static_cast<Eigen::Index>(sizes_mm.size()))
        throw base::InvalidArgument(
            fmt::format("{} points with {} sizes", at.rows(), sizes_mm.size()));
    std::vector<geom::Box3> boxes;
    for (Eigen::Index i = 0; i < at.rows(); ++i) {
        if (!(sizes_mm[static_cast<std::size_t>(i)] > 0.0))
            throw base::InvalidArgument(fmt::format("size {} is {}; it must be positive", i + 1,
                                                    sizes_mm[static_cast<std::size_t>(i)]));
        boxes.emplace_back();
        boxes.back().add(at.row(i).transpose());
    }
    state_ = std::make_shared<State>(State{std::move(at), std::move(sizes_mm), geom::Bvh(boxes)});
}

double SizeField::operator()(const geom::Vec3& p) const {
    int nearest = 0;
    double least = (state_->at.row(0).transpose() - p).norm();
    state_->tree.nearest(p, least, [&](int i, double bound) {
        const double distance = (state_->at.row(i).transpose() - p).norm();
        // The first one of equal ones, whatever the order of the tree.
        if (distance < least || (distance == least && i < nearest)) {
            least = distance;
            nearest = i;
        }
        return std::min(bound, least);
    });
    return state_->sizes[static_cast<std::size_t>(nearest)];
}

namespace {

/// Cells that an edge's sizes ask for.
double cells_wanted(const EdgePoints& edge, const SizeField& sizes) {
    double cells = 0.0;
    for (Eigen::Index k = 0; k + 1 < edge.points.rows(); ++k) {
        const geom::Vec3 a = edge.points.row(k), b = edge.points.row(k + 1);
        cells += std::ceil((b - a).norm() / sizes(0.5 * (a + b)));
    }
    return cells;
}

/// Before many rounds have made ever larger grids.
void require_memory(const Plan& plan, const SizeField& sizes) {
    std::vector<double> wanted;
    for (const EdgePoints& edge : plan.edges) wanted.push_back(cells_wanted(edge, sizes));
    double points = 0.0, largest = 0.0;
    for (const Block& block : plan.layout.blocks) {
        std::array<double, 4> cells{};
        for (std::size_t side = 0; side < 4; ++side)
            for (const BlockEdgeUse& use : block.sides[side])
                cells[side] += wanted[static_cast<std::size_t>(use.edge)];
        const double count = std::max(cells[0], cells[2]) * std::max(cells[1], cells[3]);
        points += count;
        largest = std::max(largest, count);
    }
    grid::require_memory(points, largest * block_point_bytes);
}

}  // namespace

Plan refined(const Plan& plan, const SizeField& sizes, int max_rounds) {
    require_memory(plan, sizes);
    const LineError times_too_long = [&](const geom::Vec3& a, const geom::Vec3& b,
                                         const geom::Vec3& middle) {
        return (b - a).norm() / sizes(middle);
    };
    return refined(plan, times_too_long, 1.0, max_rounds);
}

}  // namespace patchwright::grid
