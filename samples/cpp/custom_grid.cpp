// A grid with cell sizes by a function of one's own, and points taken block by block for a format
// of one's own: here a table of the blocks. custom_grid CAGE.obj GRID.vtm
#include <patchwright/grid/write.h>
#include <patchwright/mesh/obj.h>

#include <algorithm>
#include <iostream>
#include <numbers>

namespace pw = patchwright;
using pw::geom::Vec3;

int main(int, char** arguments) {
    const pw::mesh::Cage cage = pw::mesh::read_obj(std::filesystem::path(arguments[1])).cage;
    const pw::geom::Box3 box = pw::geom::bounding_box(cage.points);

    // Cells of 4 % of the diagonal, down to an eighth of that near the end of the longest axis.
    Eigen::Index axis = 0;
    (box.max - box.min).maxCoeff(&axis);
    const auto size = [&](const Vec3& point) {
        const double away = (box.max[axis] - point[axis]) / (box.max[axis] - box.min[axis]);
        return 0.04 * box.diagonal() * std::clamp(2 * away, 0.125, 1.0);
    };
    const pw::grid::BlockLayout layout = pw::grid::make_layout(cage);
    const pw::grid::Plan plan = pw::grid::make_plan(layout, {.size = size});
    const pw::grid::SurfaceGrid grid(plan);

    pw::grid::BlockPoints points;
    for (int block = 0; block < grid.block_count(); ++block) {
        grid.evaluate(block, points);
        std::cout << plan.layout.blocks[std::size_t(block)].name << ": " << points.ni << " x "
                  << points.nj << " points, from " << points.at(0, 0).transpose() << "\n";
    }

    const pw::grid::GridQuality quality = pw::grid::write_grid(grid, arguments[2]);
    std::cout << quality.cells << " cells, smallest angle "
              << quality.min_angle.worst * 180 / std::numbers::pi << " degrees, " << quality.folded
              << " folded\n";
    return quality.folded == 0 ? 0 : 3;
}
