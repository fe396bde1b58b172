#include "grid/memory.h"

#include <patchwright/adapt/refinement.h>
#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::adapt {

namespace {

/// Cells that an edge's sizes ask for.
double cells_wanted(const grid::EdgePoints& edge, const Criteria& criteria) {
    double cells = 0.0;
    for (Eigen::Index k = 0; k + 1 < edge.points.rows(); ++k) {
        const geom::Vec3 a = edge.points.row(k), b = edge.points.row(k + 1);
        const double size = std::max((*criteria.sizes)(0.5 * (a + b)), criteria.smallest_mm);
        cells += std::ceil((b - a).norm() / size);
    }
    return cells;
}

/// Before many rounds have made ever larger grids.
void require_memory(const grid::Plan& plan, const Criteria& criteria) {
    std::vector<double> wanted;
    for (const grid::EdgePoints& edge : plan.edges) wanted.push_back(cells_wanted(edge, criteria));
    double points = 0.0, largest = 0.0;
    for (const grid::Block& block : plan.layout.blocks) {
        std::array<double, 4> cells{};
        for (std::size_t side = 0; side < 4; ++side)
            for (const grid::BlockEdgeUse& use : block.sides[side])
                cells[side] += wanted[static_cast<std::size_t>(use.edge)];
        const double count = std::max(cells[0], cells[2]) * std::max(cells[1], cells[3]);
        points += count;
        largest = std::max(largest, count);
    }
    grid::require_memory(points, largest * grid::block_point_bytes);
}

}  // namespace

grid::LineError refinement_error(const Criteria& criteria) {
    if (!criteria.sizes && !criteria.sensor)
        throw base::InvalidArgument("neither sizes nor a sensor say where to refine");
    if (!(criteria.sensor_jump > 0.0) || !(criteria.smallest_mm >= 0.0))
        throw base::InvalidArgument(
            fmt::format("the sensor's jump is {} and the smallest cell {} mm; a share above 0 and "
                        "a length from 0 are needed",
                        criteria.sensor_jump, criteria.smallest_mm));
    return [criteria](const geom::Vec3& a, const geom::Vec3& b, const geom::Vec3& middle) {
        const double length = (b - a).norm();
        if (length < 2.0 * criteria.smallest_mm) return 0.0;
        double error = 0.0;
        if (criteria.sizes) error = length / (*criteria.sizes)(middle);
        if (criteria.sensor && criteria.sensor->range() > 0.0) {
            const Sensor& q = *criteria.sensor;
            const double on_the_way = q(middle);
            const double jump = std::abs(on_the_way - q(a)) + std::abs(q(b) - on_the_way);
            error = std::max(error, jump / (criteria.sensor_jump * q.range()));
        }
        return error;
    };
}

grid::Plan refined(const grid::Plan& plan, const Criteria& criteria,
                   const grid::RefineOptions& options) {
    const grid::LineError error = refinement_error(criteria);
    if (criteria.sizes) require_memory(plan, criteria);
    return grid::refined(plan, error, 1.0, options);
}

}  // namespace patchwright::adapt
