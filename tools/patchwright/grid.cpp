#include "blocks.h"
#include "checks.h"
#include "command.h"
#include "point_values.h"
#include "view.h"

#include <patchwright/adapt/write.h>
#include <patchwright/base/error.h>
#include <patchwright/grid/layers.h>
#include <patchwright/grid/rules.h>
#include <patchwright/grid/smooth.h>
#include <patchwright/grid/write.h>
#include <patchwright/measure/verdict.h>
#include <patchwright/subd/normal_control.h>

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

namespace patchwright::cli {

namespace {

struct GridOptions {
    CommonOptions common;
    ViewArguments view{.layer = report::PictureLayer::Patches};
    std::string cage, output;
    std::string cage_unit = "mm", unit = "mm";
    BlockArguments blocks;
    int levels = 0, coarsen = 0;
    bool smooth = false;
    std::string law = "uniform";
    bool curvature = false;
    std::string first_cell;
    std::vector<std::string> clusters;
    std::string rules, size_field, size_array, sensor, sensor_array, smallest, hanging_nodes;
    double sensor_jump = adapt::Criteria{}.sensor_jump;
    std::string form = "binary", endian = "little";
    int layers = 0;
    std::string layer_height, thickness, far_field;
    double growth = 1.2;
};

bool refines(const GridOptions& options) {
    return !options.size_field.empty() || !options.sensor.empty();
}

/// "A:B=0.1mm"
grid::BorderCluster parse_cluster(const std::string& text, double diagonal) {
    const auto equals = text.rfind('=');
    const auto colon = text.find(':');
    if (equals == std::string::npos || colon == std::string::npos || colon > equals) {
        throw base::UsageError(fmt::format(
            "--cluster {}: write FAMILY:FAMILY=LENGTH, for example upper:lower=0.1mm", text));
    }
    return {text.substr(0, colon), text.substr(colon + 1, equals - colon - 1),
            base::parse_length(text.substr(equals + 1)).in_millimetres(diagonal)};
}

grid::PlanOptions plan_options(const GridOptions& options, double diagonal) {
    const auto length = [&](const std::string& text) {
        return text.empty() ? 0.0 : base::parse_length(text).in_millimetres(diagonal);
    };
    grid::PlanOptions plan = plan_options(options.blocks, diagonal);
    plan.levels = options.levels;
    plan.law = grid::spacing_laws().at(options.law);
    plan.first_at_creases_mm = length(options.first_cell);
    if (options.curvature) plan.measure = grid::Measure::Curvature;
    for (const std::string& text : options.clusters) {
        plan.clusters.push_back(parse_cluster(text, diagonal));
    }
    const bool sized = plan.first_at_creases_mm > 0.0 || !plan.clusters.empty();
    if (sized && plan.law == grid::Law::Uniform) {
        throw base::UsageError(
            "--first-cell and --cluster need --spacing tanh or geometric (or cosine)");
    }
    return plan;
}

adapt::SizeField read_size_field(const GridOptions& options, base::LengthUnit unit) {
    PointValues sizes = read_point_values(options.size_field, {.unit = unit,
                                                               .array = options.size_array,
                                                               .usual_array = "size",
                                                               .must_be_positive = true});
    for (double& size : sizes.values) size *= base::millimetres_per(unit);
    return {std::move(sizes.at), std::move(sizes.values)};
}

adapt::Sensor read_sensor(const GridOptions& options, base::LengthUnit unit) {
    PointValues values =
        read_point_values(options.sensor, {.unit = unit, .array = options.sensor_array});
    return {std::move(values.at), std::move(values.values)};
}

/// Smallest cell by a sensor where none is given: far below what a surface grid's cells are, and
/// far above rounding.
constexpr double smallest_by_sensor_rel = 1e-3;

/// What the grid is refined by, if anything.
std::optional<adapt::Criteria> read_criteria(const GridOptions& options, base::LengthUnit unit,
                                             double diagonal) {
    if (!refines(options)) return std::nullopt;
    adapt::Criteria criteria{.sensor_jump = options.sensor_jump};
    if (!options.size_field.empty()) criteria.sizes = read_size_field(options, unit);
    if (!options.sensor.empty()) {
        criteria.sensor = read_sensor(options, unit);
        criteria.smallest_mm = smallest_by_sensor_rel * diagonal;
    }
    if (!options.smallest.empty())
        criteria.smallest_mm = base::parse_length(options.smallest).in_millimetres(diagonal);
    return criteria;
}

std::vector<grid::EdgeRule> read_rules(const std::string& file, const grid::BlockLayout& layout,
                                       base::LengthUnit unit, double diagonal) {
    std::ifstream stream(file);
    if (!stream) throw base::InputError(fmt::format("{}: cannot be read", file));
    const std::string text(std::istreambuf_iterator<char>(stream), {});
    return about_input(file, [&] { return grid::parse_rules(text, layout, unit, diagonal); });
}

void check_options(const GridOptions& options) {
    if (refines(options) && options.levels > 0)
        throw base::UsageError(
            fmt::format("{} and --levels do not go together: halved cells are no multiples",
                        options.sensor.empty() ? "--size-field" : "--sensor"));
    if (!options.size_array.empty() && options.size_field.empty())
        throw base::UsageError("--size-array names an array of --size-field FILE.vtu; give both");
    if (!options.sensor_array.empty() && options.sensor.empty())
        throw base::UsageError("--sensor-array names an array of --sensor FILE.vtu; give both");
    if (!options.smallest.empty() && !refines(options))
        throw base::UsageError("--smallest bounds --size-field and --sensor; give one of them");
    if (!options.hanging_nodes.empty() && !refines(options))
        throw base::UsageError(
            "--hanging-nodes divides cells where --size-field or --sensor ask for it; give one");
    if (!options.hanging_nodes.empty() && options.layers > 0)
        throw base::UsageError(
            "--hanging-nodes and --layers do not go together: layers grow on whole lines");
    if (!options.hanging_nodes.empty() && options.smooth)
        throw base::UsageError(
            "--hanging-nodes and --smooth do not go together: single cells are divided by their "
            "parameters");
    if (options.coarsen > options.levels)
        throw base::UsageError(fmt::format("--coarsen {} needs --levels {} or more",
                                           options.coarsen, options.coarsen));
    if (options.layers > 0 && options.layer_height.empty() == options.thickness.empty())
        throw base::UsageError(
            "--layers needs either --layer-height (of the first cell) or --thickness");
    if (!options.far_field.empty() && options.layers == 0)
        throw base::UsageError("--farfield goes on from --layers; give both");
}

grid::LayerOptions layer_options(const GridOptions& options, double diagonal) {
    grid::LayerOptions layers{.cells = options.layers, .growth = options.growth};
    if (options.thickness.empty())
        layers.first_mm = base::parse_length(options.layer_height).in_millimetres(diagonal);
    else
        layers.thickness_mm = base::parse_length(options.thickness).in_millimetres(diagonal);
    if (!options.far_field.empty())
        layers.far_field_mm = base::parse_length(options.far_field).in_millimetres(diagonal);
    return layers;
}

/// Larger grids are drawn where a picture is asked for, not for the report alone: their cells are
/// smaller than pixels.
constexpr std::int64_t most_points_in_report = 1'000'000;

/// @param grid  with points on the surface
template <class Grid>
void draw(Run& run, const ViewArguments& options, const Grid& grid, std::int64_t points,
          const char* caption) {
    if (!shows_anything(run, options) ||
        (options.picture.empty() && points > most_points_in_report))
        return;
    add_drawing(run, options, report::draw_grid(grid), caption);
}

/// A grid of blocks: file, figures and picture.
report::GridFigures write_blocks(Run& run, const GridOptions& options, const grid::Plan& plan,
                                 double diagonal, const grid::GridWriteOptions& write) {
    report::GridFigures figures{options.output, {}};
    const grid::SurfaceGrid surface(plan);
    if (options.layers > 0) {
        grid::LayerOptions layers = layer_options(options, diagonal);
        layers.progress = run.progress();
        const grid::LayerGrid volume(plan, layers);
        run.end_stage("layers");
        figures.quality = grid::write_grid(volume, options.output, run.outputs, write);
    } else {
        figures.quality = grid::write_grid(surface, options.output, run.outputs, write);
    }
    run.end_stage("write");
    draw(run, options.view, surface, plan.point_count(),
         "The surface grid: blocks in colours, their sides red");
    return figures;
}

/// The same of a grid that is refined cell by cell.
report::GridFigures write_cells(Run& run, const GridOptions& options, const grid::Plan& plan,
                                const adapt::Criteria& criteria, base::LengthUnit unit) {
    const adapt::LocalGrid grid =
        adapt::refined_locally(plan, criteria, {.progress = run.progress()});
    run.end_stage("refine");
    const auto cells =
        options.hanging_nodes == "quads" ? adapt::LocalCells::Quads : adapt::LocalCells::Polygons;
    report::GridFigures figures{
        options.output, adapt::write_local_grid(grid, options.output, run.outputs, {unit, cells}),
        report::GridFigures::Local{grid.deepest(), grid.hanging_nodes()}};
    run.end_stage("write");
    draw(run, options.view, grid, grid.points.rows(), "The surface grid: blocks in colours");
    return figures;
}

int make_grid(const GridOptions& options) {
    const auto cage_unit = base::parse_length_unit(options.cage_unit);
    const bool is_local = !options.hanging_nodes.empty();
    grid::GridWriteOptions write{.unit = base::parse_length_unit(options.unit)};
    write.plot3d = {options.form == "ascii"     ? grid::Plot3dOptions::Form::Ascii
                    : options.form == "fortran" ? grid::Plot3dOptions::Form::Fortran
                                                : grid::Plot3dOptions::Form::Binary,
                    options.endian == "big"};
    Run run(options.common,
            {{options.cage, options.rules, options.size_field, options.sensor},
             {{"--output", options.output, is_local ? OutputKind::LocalGrid : OutputKind::Grid},
              {"--picture", options.view.picture, OutputKind::Picture}}});
    check_options(options);
    run.report.unit = write.unit;
    write.progress = run.progress();
    const mesh::Cage cage =
        about_input(options.cage, [&] { return read_cage(run, options.cage, cage_unit); });
    const double diagonal = geom::bounding_box(cage.points).diagonal();
    run.end_stage("read");

    const auto controlled = about_input(options.cage, [&] { return subd::control_normals(cage); });
    const grid::BlockLayout layout = make_layout(controlled, options.blocks);
    grid::PlanOptions wanted = plan_options(options, diagonal);
    if (!options.rules.empty()) {
        wanted.rules = read_rules(options.rules, layout, cage_unit, diagonal);
    }
    grid::Plan plan = about_input(options.cage, [&] { return grid::make_plan(layout, wanted); });
    const auto criteria = read_criteria(options, cage_unit, diagonal);
    if (criteria && !is_local) plan = adapt::refined(plan, *criteria, {.progress = run.progress()});
    run.end_stage("plan");
    if (options.smooth) {
        plan = grid::smoothed(plan, {.progress = run.progress()});
        run.end_stage("smooth");
    }
    plan = about_input(options.cage, [&] { return grid::coarsened(plan, options.coarsen); });

    run.report.grid = is_local ? write_cells(run, options, plan, *criteria, write.unit)
                               : write_blocks(run, options, plan, diagonal, write);
    const grid::GridQuality& quality = run.report.grid->quality;
    run.report.verdict = measure::assess(
        {.bad_grid_cells = measure::Failures{int(quality.folded + quality.negative), {}},
         .is_grid = true});
    return run.finish();
}

void add_level_options(CLI::App& command, GridOptions& options) {
    command
        .add_option("--levels", options.levels,
                    "make numbers of cells multiples of 2^LEVELS, for coarser grids")
        ->check(number_in(0, 16));
    command.add_option("--coarsen", options.coarsen, "write every 2^COARSEN-th point only")
        ->check(number_in(0, 16));
}

void add_spacing_options(CLI::App& command, GridOptions& options) {
    command.add_flag("--smooth", options.smooth,
                     "let points slide on the surface until angles are near right ones, and those "
                     "around an extraordinary vertex alike; points of creases and borders stay on "
                     "these");
    command.add_option("--spacing", options.law, "uniform, geometric, tanh or cosine")
        ->check(CLI::IsMember({"uniform", "geometric", "tanh", "cosine"}).description(""))
        ->capture_default_str();
    command.add_flag("--curvature", options.curvature,
                     "more points where block edges are curved, before the spacing law");
    command
        .add_option("--first-cell", options.first_cell,
                    "length of the first cell of lines that end on a crease, as trailing edges "
                    "are")
        ->check(is_length());
    command.add_option("--cluster", options.clusters,
                       "FAMILY:FAMILY=LENGTH: first cell of lines that end where blocks of these "
                       "families meet; an empty name is any");
    command.add_option("--rules", options.rules,
                       "JSON file with rules for single block edges: [{\"at\": [x, y, z], "
                       "\"cells\": 40, \"spacing\": \"tanh\", \"near\": \"0.1mm\", \"far\": "
                       "\"2mm\"}]; the edge nearest to the point and all that lines connect to it");
}

void add_refinement_options(CLI::App& command, GridOptions& options) {
    command.add_option("--size-field", options.size_field,
                       "X,Y,Z,SIZE a line, or a VTK file with sizes at its points or cells, in the "
                       "cage's unit: cells are halved along whole lines until they are no longer "
                       "than the size at the nearest point");
    command.add_option("--size-array", options.size_array,
                       "which array of the .vtu file holds the sizes; else the one named size, or "
                       "the only one with one number a point or cell");
    command.add_option("--sensor", options.sensor,
                       "X,Y,Z,VALUE a line, or a VTK file, of a solution on the surface, pressure "
                       "for instance: cells are halved along whole lines until the value changes "
                       "by no more than --sensor-jump along each");
    command.add_option("--sensor-array", options.sensor_array,
                       "which array of the .vtu file is the sensor, if it has several");
    command
        .add_option("--sensor-jump", options.sensor_jump,
                    "most change along a cell, as a share of the sensor's range")
        ->check(number_in(1e-6, 1.0))
        ->capture_default_str();
    command
        .add_option("--smallest", options.smallest,
                    "no cells smaller than this come of --size-field and --sensor; with --sensor "
                    "1e-3rel unless given")
        ->check(is_length());
    command
        .add_option("--hanging-nodes", options.hanging_nodes,
                    "divide single cells 2 x 2 instead of whole lines, and write an unstructured "
                    "grid (.cgns, .vtu): hanging nodes are corners of the cells that they lie on "
                    "(polygons), or cells have four corners (quads)")
        ->check(CLI::IsMember({"polygons", "quads"}).description(""));
}

void add_layer_options(CLI::App& command, GridOptions& options) {
    command
        .add_option("--layers", options.layers,
                    "cells grown off the surface along its normals: a volume grid")
        ->check(number_in(0, 10000));
    command.add_option("--layer-height", options.layer_height, "height of the first layer")
        ->check(is_length());
    command.add_option("--thickness", options.thickness, "height of all layers together")
        ->check(is_length());
    command
        .add_option("--farfield", options.far_field,
                    "radius of a sphere that cells fill from the layers on, or of half a sphere "
                    "where the surface ends in a plane")
        ->check(is_length());
    command.add_option("--growth", options.growth, "each layer's height over the one below")
        ->check(number_in(0.5, 5.0))
        ->capture_default_str();
}

}  // namespace

void register_grid(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<GridOptions>();
    CLI::App* command =
        app.add_subcommand("grid", "block-structured grid on the limit surface of a cage");
    command->add_option("cage", options->cage, "control mesh (OBJ), usually a fitted one")
        ->required();
    command
        ->add_option("-o,--output", options->output,
                     "grid to write: .cgns, .xyz or .p3d (Plot3D), .vtm (VTK); .cgns or .vtu with "
                     "--hanging-nodes")
        ->required();
    command->add_option("--cage-unit", options->cage_unit, "unit of the cage's numbers")
        ->check(is_unit())
        ->capture_default_str();
    command->add_option("--unit", options->unit, "unit of the grid: mm, cm, m, in or ft")
        ->check(is_unit())
        ->capture_default_str();
    add_block_options(*command, options->blocks);
    add_level_options(*command, *options);
    add_spacing_options(*command, *options);
    add_refinement_options(*command, *options);
    command
        ->add_option("--plot3d", options->form, "Plot3D files: binary, fortran (records) or ascii")
        ->check(CLI::IsMember({"binary", "fortran", "ascii"}).description(""))
        ->capture_default_str();
    command->add_option("--endian", options->endian, "byte order of Plot3D files: little or big")
        ->check(CLI::IsMember({"little", "big"}).description(""))
        ->capture_default_str();
    add_layer_options(*command, *options);
    add_picture_options(*command, options->view);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = make_grid(*options); });
}

}  // namespace patchwright::cli
