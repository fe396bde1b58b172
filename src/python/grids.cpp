#include "grids.h"

#include "cage.h"
#include "call.h"
#include "options.h"

#include <patchwright/adapt/write.h>
#include <patchwright/grid/layers.h>
#include <patchwright/grid/rules.h>
#include <patchwright/grid/smooth.h>
#include <patchwright/grid/write.h>
#include <patchwright/report/run_report.h>
#include <patchwright/subd/normal_control.h>

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <functional>

namespace patchwright::python {

namespace {

constexpr int most_grid_levels = 16;

double length_or(const Options& options, const char* name, double diagonal, double otherwise) {
    const std::optional<std::string> text = options.text(name);
    return text ? base::parse_length(*text).in_millimetres(diagonal) : otherwise;
}

/// "A:B=0.1mm"
grid::BorderCluster parse_cluster(const std::string& text, double diagonal) {
    const auto equals = text.rfind('='), colon = text.find(':');
    if (equals == std::string::npos || colon == std::string::npos || colon > equals)
        throw base::UsageError(fmt::format(
            "cluster {}: write FAMILY:FAMILY=LENGTH, for example upper:lower=0.1mm", text));
    return {text.substr(0, colon), text.substr(colon + 1, equals - colon - 1),
            base::parse_length(text.substr(equals + 1)).in_millimetres(diagonal)};
}

grid::PlanOptions plan_options(const Options& options, double diagonal) {
    using grid::Law;
    constexpr int most_points = 1 << 20, usual_points = 17;
    grid::PlanOptions plan{
        .size_mm = length_or(options, "size", diagonal, 0.0),
        .cells = options.integer("points", 2, most_points).value_or(usual_points) - 1,
        .levels = options.integer("levels", 0, most_grid_levels).value_or(0),
        .law = options.choice<Law>("spacing", {{"uniform", Law::Uniform},
                                               {"geometric", Law::Geometric},
                                               {"tanh", Law::Tanh},
                                               {"cosine", Law::Cosine}}),
        .first_at_creases_mm = length_or(options, "first_cell", diagonal, 0.0)};
    if (options.flag("curvature")) plan.measure = grid::Measure::Curvature;
    for (const std::string& text : options.texts("clusters"))
        plan.clusters.push_back(parse_cluster(text, diagonal));
    const bool is_sized = plan.first_at_creases_mm > 0.0 || !plan.clusters.empty();
    if (is_sized && plan.law == Law::Uniform)
        throw base::UsageError(
            "first_cell and clusters need spacing tanh or geometric (or cosine)");
    return plan;
}

/// Cells grown off the surface; none where the options ask for none.
std::optional<grid::LayerOptions> layer_options(const Options& options, double diagonal) {
    constexpr int most_layers = 10000;
    const int cells = options.integer("layers", 0, most_layers).value_or(0);
    const bool has_far_field = options.text("farfield").has_value();
    if (has_far_field && cells == 0)
        throw base::UsageError("farfield goes on from layers; give both");
    if (cells == 0) return std::nullopt;
    if (options.text("layer_height").has_value() == options.text("thickness").has_value())
        throw base::UsageError("layers need either layer_height (of the first cell) or thickness");
    return grid::LayerOptions{.cells = cells,
                              .growth = options.number("growth", 0.5, 5.0).value_or(1.2),
                              .first_mm = length_or(options, "layer_height", diagonal, 0.0),
                              .thickness_mm = length_or(options, "thickness", diagonal, 0.0),
                              .far_field_mm = length_or(options, "farfield", diagonal, 0.0)};
}

/// Rows of x, y, z and a number, in millimetres.
struct PointValues {
    geom::Points at;
    std::vector<double> values;
};

std::optional<PointValues> point_values(const Options& options, const char* name,
                                        const char* number) {
    const std::optional<Doubles> rows = options.doubles(name);
    if (!rows) return std::nullopt;
    if (rows->ndim() != 2 || rows->shape(1) != 4 || rows->shape(0) == 0)
        throw base::UsageError(
            fmt::format("{}: rows of x, y, z and a {} are needed", name, number));
    if (options.integer("levels", 0, most_grid_levels).value_or(0) > 0)
        throw base::UsageError(
            fmt::format("{} and levels do not go together: halved cells are no multiples", name));
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>> table(
        rows->data(), rows->shape(0), 4);
    return PointValues{table.leftCols<3>(),
                       std::vector<double>(table.col(3).begin(), table.col(3).end())};
}

/// What the grid is refined by, if anything.
std::optional<adapt::Criteria> criteria(const Options& options, double diagonal) {
    constexpr double smallest_by_sensor_rel = 1e-3, least_jump = 1e-6;
    auto sizes = point_values(options, "size_field", "size");
    auto sensor = point_values(options, "sensor", "value");
    if (!sizes && !sensor) return std::nullopt;
    adapt::Criteria criteria;
    if (sizes) {
        for (std::size_t i = 0; i < sizes->values.size(); ++i)
            if (!(sizes->values[i] > 0.0))
                throw base::UsageError(fmt::format("size_field: size {} is {}; it must be positive",
                                                   i, sizes->values[i]));
        criteria.sizes.emplace(std::move(sizes->at), std::move(sizes->values));
    }
    if (sensor) criteria.sensor.emplace(std::move(sensor->at), std::move(sensor->values));
    criteria.sensor_jump =
        options.number("sensor_jump", least_jump, 1.0).value_or(criteria.sensor_jump);
    criteria.smallest_mm =
        length_or(options, "smallest", diagonal, sensor ? smallest_by_sensor_rel * diagonal : 0.0);
    return criteria;
}

/// A grid's points, with the plan that they belong to.
struct Grid {
    grid::Plan plan;
    std::unique_ptr<grid::BlockSource> points;
    std::optional<adapt::LocalGrid> local;  ///< where single cells are divided; without `points`
};

struct GridOptions {
    grid::BlockCovering covering = grid::BlockCovering::Groups;
    bool join = false;
    grid::PlanOptions plan;
    std::string rules;  ///< JSON
    double diagonal_mm = 0.0;
    int coarsen = 0;
    std::optional<adapt::Criteria> refinement;
    std::optional<grid::LayerOptions> layers;
    bool smooth = false;
    bool is_local = false;
    base::Progress progress;
};

std::unique_ptr<Grid> make_grid(const mesh::Cage& cage, GridOptions wanted) {
    grid::BlockLayout layout = grid::make_layout(subd::control_normals(cage), wanted.covering);
    if (wanted.join && wanted.covering != grid::BlockCovering::Faces)
        layout = grid::join_all(layout);
    if (!wanted.rules.empty()) {
        try {
            wanted.plan.rules = grid::parse_rules(wanted.rules, layout,
                                                  base::LengthUnit::Millimetre, wanted.diagonal_mm);
        } catch (const base::InputError& error) {
            throw base::UsageError(std::string("rules: ") + error.what());
        }
    }
    auto made = std::make_unique<Grid>();
    made->plan = grid::make_plan(layout, wanted.plan);
    if (wanted.refinement && !wanted.is_local)
        made->plan = adapt::refined(made->plan, *wanted.refinement, {.progress = wanted.progress});
    if (wanted.smooth) made->plan = grid::smoothed(made->plan, {.progress = wanted.progress});
    made->plan = grid::coarsened(made->plan, wanted.coarsen);
    if (wanted.is_local) {
        made->local =
            adapt::refined_locally(made->plan, *wanted.refinement, {.progress = wanted.progress});
        return made;
    }
    if (wanted.layers)
        made->points = std::make_unique<grid::LayerGrid>(made->plan, *wanted.layers);
    else
        made->points = std::make_unique<grid::SurfaceGrid>(made->plan);
    return made;
}

/// Shape (ni, nj, 3), or (ni, nj, nk, 3).
py::array_t<double> block_array(const Grid& grid, int block, bool is_volume) {
    grid::BlockPoints points;
    {
        const py::gil_scoped_release released;
        grid.points->evaluate(block, points);
    }
    std::vector<py::ssize_t> shape{points.ni, points.nj};
    if (is_volume) shape.push_back(points.nk);
    shape.push_back(3);
    py::array_t<double> array(shape);
    double* to = array.mutable_data();
    for (int i = 0; i < points.ni; ++i)
        for (int j = 0; j < points.nj; ++j)
            for (int k = 0; k < points.nk; ++k)
                for (int c = 0; c < 3; ++c) *to++ = points.at(i, j, k)[c];
    return array;
}

struct Planned {
    std::unique_ptr<Grid> grid;
    bool is_volume = false;
};

Planned plan_grid(const mesh::Cage& cage, const Options& options, Call& call) {
    using grid::BlockCovering;
    const double diagonal = geom::bounding_box(cage.points).diagonal();
    GridOptions wanted{
        .covering = options.choice<BlockCovering>("blocks", {{"groups", BlockCovering::Groups},
                                                             {"charts", BlockCovering::Charts},
                                                             {"faces", BlockCovering::Faces}}),
        .join = options.flag("join"),
        .plan = plan_options(options, diagonal),
        .rules = options.text("rules").value_or(""),
        .diagonal_mm = diagonal,
        .refinement = criteria(options, diagonal),
        .layers = layer_options(options, diagonal),
        .smooth = options.flag("smooth"),
        .is_local = options.text("hanging_nodes").has_value(),
        .progress = call.progress()};
    if (wanted.is_local && !wanted.refinement)
        throw base::UsageError(
            "hanging_nodes divides cells where size_field or sensor ask for it; give one");
    if (wanted.is_local && wanted.layers)
        throw base::UsageError(
            "hanging_nodes and layers do not go together: layers grow on whole lines");
    if (wanted.is_local && wanted.smooth)
        throw base::UsageError(
            "hanging_nodes and smooth do not go together: single cells are divided by their "
            "parameters");
    wanted.coarsen = options.integer("coarsen", 0, wanted.plan.levels).value_or(0);
    if (wanted.layers) wanted.layers->progress = call.progress();
    const bool is_volume = wanted.layers.has_value();
    return {call.run("cage", [&] { return make_grid(cage, std::move(wanted)); }), is_volume};
}

py::list grid_blocks(const PyCage& given, const py::dict& named, py::object progress) {
    Call call(std::move(progress));
    const Planned planned = plan_grid(given.checked(), Options(named), call);
    py::list blocks;
    for (int block = 0; block < planned.grid->points->block_count(); ++block)
        blocks.append(py::make_tuple(planned.grid->plan.layout.blocks[std::size_t(block)].name,
                                     block_array(*planned.grid, block, planned.is_volume)));
    return blocks;
}

/// By block: faces (ni, nj), u and v (ni, nj, 2), and sectors (ni, nj) or None.
py::tuple place_arrays(const grid::BlockPlaces& places, int ni, int nj) {
    const auto whole = [&](const std::vector<std::int32_t>& values) {
        py::array_t<std::int32_t> array({ni, nj});
        for (int i = 0; i < ni; ++i)
            for (int j = 0; j < nj; ++j)
                array.mutable_at(i, j) = values[std::size_t(i) + std::size_t(ni) * std::size_t(j)];
        return array;
    };
    py::array_t<double> uv({ni, nj, 2});
    for (int i = 0; i < ni; ++i) {
        for (int j = 0; j < nj; ++j) {
            const std::size_t n = std::size_t(i) + std::size_t(ni) * std::size_t(j);
            uv.mutable_at(i, j, 0) = places.u[n];
            uv.mutable_at(i, j, 1) = places.v[n];
        }
    }
    py::object sectors = py::none();
    if (!places.sectors.empty()) sectors = whole(places.sectors);
    return py::make_tuple(whole(places.faces), uv, sectors);
}

py::list grid_places(const PyCage& given, const py::dict& named, py::object progress) {
    Call call(std::move(progress));
    const Planned planned = plan_grid(given.checked(), Options(named), call);
    const grid::Plan& plan = planned.grid->plan;
    const grid::BlockEvaluator evaluator(plan);
    py::list blocks;
    for (int block = 0; block < int(plan.layout.blocks.size()); ++block) {
        grid::BlockPlaces places;
        call.run("cage", [&] {
            evaluator.places(block, places);
            return 0;
        });
        const auto [ni, nj] = plan.size(block);
        blocks.append(py::make_tuple(plan.layout.blocks[std::size_t(block)].name,
                                     place_arrays(places, ni, nj)));
    }
    return blocks;
}

grid::Plot3dOptions plot3d_options(const Options& options) {
    using Form = grid::Plot3dOptions::Form;
    return {
        options.choice<Form>(
            "form", {{"binary", Form::Binary}, {"fortran", Form::Fortran}, {"ascii", Form::Ascii}}),
        options.choice<bool>("endian", {{"little", false}, {"big", true}})};
}

py::tuple write_grid(const PyCage& given, const std::filesystem::path& output,
                     const py::dict& named, py::object progress) {
    const Options options(named);
    const bool is_local = options.text("hanging_nodes").has_value();
    const auto cells = options.choice<adapt::LocalCells>(
        "hanging_nodes",
        {{"polygons", adapt::LocalCells::Polygons}, {"quads", adapt::LocalCells::Quads}});
    if (is_local)
        adapt::local_format(output);
    else
        grid::grid_format(output);
    base::OutputTarget{output};
    grid::GridWriteOptions writing{
        .unit = base::parse_length_unit(options.text("unit").value_or("mm")),
        .plot3d = plot3d_options(options)};
    const mesh::Cage cage = given.checked();
    Call call(std::move(progress));
    writing.progress = call.progress();
    const Planned planned = plan_grid(cage, options, call);
    report::GridFigures figures{output.string(), {}};
    figures.quality = call.run("cage", [&] {
        if (!is_local) return grid::write_grid(*planned.grid->points, output, writing);
        base::OutputSet outputs;
        grid::GridQuality quality =
            adapt::write_local_grid(*planned.grid->local, output, outputs, {writing.unit, cells});
        outputs.commit();
        return quality;
    });
    const grid::GridQuality& quality = figures.quality;
    if (is_local)
        figures.local = {planned.grid->local->deepest(), planned.grid->local->hanging_nodes()};
    report::RunReport report{.unit = writing.unit,
                             .options = options.listed("grid"),
                             .cage = mesh::summarise(*cage.topology),
                             .grid = figures};
    report.verdict = measure::assess(
        {.bad_grid_cells = measure::Failures{int(quality.folded + quality.negative), {}},
         .is_grid = true});
    return py::make_tuple(report::to_json(report),
                          report::to_text(report, report::TextDetail::Brief));
}

}  // namespace

void bind_grids(py::module_& module) {
    module.def("grid_blocks", grid_blocks);
    module.def("grid_places", grid_places);
    module.def("grid", write_grid);
}

}  // namespace patchwright::python
