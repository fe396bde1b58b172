#include "adapt/write_local.h"
#include "grid/quad_figures.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace patchwright::adapt {

namespace {

geom::Vec3 point(const LocalGrid& grid, std::int32_t number) { return grid.points.row(number); }

/// Family by family, as these first appear.
std::vector<std::int32_t> order_by_family(const LocalGrid& grid) {
    const auto& families = grid.block_families;
    std::vector<std::int32_t> order(grid.cells.size());
    std::iota(order.begin(), order.end(), 0);
    const auto rank = [&](std::int32_t cell) {
        const std::string& family = families[std::size_t(grid.cells[std::size_t(cell)].block)];
        return std::find(families.begin(), families.end(), family) - families.begin();
    };
    std::vector<std::ptrdiff_t> ranks;
    for (const std::int32_t cell : order) ranks.push_back(rank(cell));
    std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
        return ranks[std::size_t(a)] < ranks[std::size_t(b)];
    });
    return order;
}

grid::GridQuality measure(const LocalGrid& grid, const std::vector<std::int32_t>& order,
                          grid::CellFields& fields) {
    constexpr double degrees = 180.0 / M_PI;
    grid::GridQuality q;
    q.blocks = static_cast<int>(grid.block_names.size());
    q.points = grid.points.rows();
    q.cells = static_cast<std::int64_t>(grid.cells.size());
    for (std::size_t n = 0; n < order.size(); ++n) {
        const LocalCell& cell = grid.cells[std::size_t(order[n])];
        std::array<geom::Vec3, 4> quad;
        for (std::size_t k = 0; k < 4; ++k) quad[k] = point(grid, cell.corners[k]);
        const grid::CellFigures f = grid::quad_figures(quad);
        const auto note = [&](grid::Spread& spread, bool larger, double value) {
            grid::note(spread, larger, value, cell.block, int(n), 0, 0, quad[0]);
        };
        note(q.min_angle, false, f.min_angle);
        note(q.skewness, true, f.skewness);
        note(q.aspect, true, f.aspect);
        q.folded += f.folded ? 1 : 0;
        fields.min_angle_deg.push_back(float(f.min_angle * degrees));
        fields.skewness.push_back(float(f.skewness));
        fields.aspect.push_back(float(f.aspect));
    }
    for (grid::Spread* spread : {&q.min_angle, &q.skewness, &q.aspect})
        *spread = grid::finished(*spread);
    return q;
}

}  // namespace

void LocalFile::add_corners(std::int32_t cell, std::vector<std::int32_t>& corners) const {
    const LocalCell& c = grid.cells[std::size_t(cell)];
    for (std::size_t k = 0; k < 4; ++k) {
        corners.push_back(c.corners[k]);
        if (options.cells == LocalCells::Polygons && c.hanging[k] >= 0)
            corners.push_back(c.hanging[k]);
    }
}

LocalFormat local_format(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".cgns") return LocalFormat::Cgns;
    if (extension == ".vtu") return LocalFormat::Vtk;
    throw base::UsageError(fmt::format(
        "{}: grids with hanging nodes are unstructured, which '{}' is not; use .cgns or .vtu",
        file.string(), extension));
}

grid::GridQuality write_local_grid(const LocalGrid& grid, const std::filesystem::path& file,
                                   base::OutputSet& outputs, const LocalWriteOptions& options) {
    const LocalFormat format = local_format(file);
    const auto pending = std::make_shared<base::PendingFile>(file);
    LocalFile content{.grid = grid,
                      .coordinates = {},
                      .order = order_by_family(grid),
                      .fields = {},
                      .options = options};
    grid::GridQuality quality = measure(grid, content.order, content.fields);
    const double factor = 1.0 / base::millimetres_per(options.unit);
    for (std::size_t c = 0; c < 3; ++c) {
        const Eigen::VectorXd column = grid.points.col(Eigen::Index(c)) * factor;
        content.coordinates[c].assign(column.begin(), column.end());
    }
    (format == LocalFormat::Cgns ? write_local_cgns : write_local_vtk)(content, *pending);
    outputs.add(pending);
    return quality;
}

}  // namespace patchwright::adapt
