#include "options.h"
#include "view.h"

#include <patchwright/base/error.h>
#include <patchwright/mesh/polylines.h>
#include <patchwright/subd/curve.h>
#include <patchwright/subd/refine.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

namespace patchwright::cli {

namespace {

constexpr double max_elements = 2e7;  ///< faces or points

struct SubdivideOptions {
    CommonOptions common;
    ViewArguments view{.layer = report::PictureLayer::Patches};
    std::string cage, output;
    int levels = 1;
    subd::CurveScheme scheme = subd::CurveScheme::CubicEdgeSplit;
};

void refuse_levels(double count, const char* what, int levels) {
    if (count > max_elements)
        throw base::UsageError(
            fmt::format("{} levels would make {:.3g} {}; use fewer", levels, count, what));
}

/// @throw InputError for what has no curve
void check_polylines(const SubdivideOptions& options,
                     const std::vector<mesh::Polyline>& polylines) {
    if (!options.view.picture.empty())
        throw base::UsageError("--picture draws meshes, and " + options.cage + " holds polylines");
    double points = 0.0;
    for (const mesh::Polyline& polyline : polylines) {
        points += double(polyline.points.rows());
        if (options.scheme != subd::CurveScheme::CubicEdgeSplit && polyline.points.rows() < 3)
            throw base::InputError(
                fmt::format("{}: line {}: two points have no corner to be cut; use --scheme "
                            "edge-split",
                            options.cage, polyline.line));
    }
    refuse_levels(points * std::pow(2.0, options.levels), "points", options.levels);
}

void write_polylines(Run& run, const std::vector<mesh::Polyline>& polylines,
                     const std::string& file) {
    const auto pending = std::make_shared<base::PendingFile>(file);
    pending->write(mesh::polylines_text(polylines));
    const std::vector<mesh::Polyline> read = mesh::read_polylines(pending->path());
    if (!std::equal(read.begin(), read.end(), polylines.begin(), polylines.end(),
                    [](const mesh::Polyline& a, const mesh::Polyline& b) {
                        return a.closed == b.closed && a.points.rows() == b.points.rows() &&
                               a.points == b.points;
                    }))
        throw base::OutputError(
            fmt::format("{}: other polylines are read back than were written", file));
    run.outputs.add(pending);
}

int subdivide_polylines(Run& run, const SubdivideOptions& options,
                        std::vector<mesh::Polyline> polylines) {
    run.end_stage("read");
    check_polylines(options, polylines);
    for (mesh::Polyline& polyline : polylines)
        for (int level = 0; level < options.levels; ++level)
            polyline.points = subd::refine_curve(options.scheme, polyline.points, polyline.closed);
    run.end_stage("subdivide");
    write_polylines(run, polylines, options.output);
    run.report.polylines = mesh::summarise(polylines);
    run.end_stage("write");
    return run.finish();
}

int subdivide(const SubdivideOptions& options) {
    Run run(options.common, {{options.cage},
                             {{"--output", options.output, OutputKind::Cage},
                              {"--picture", options.view.picture, OutputKind::Picture}}});
    std::vector<mesh::Polyline> polylines = mesh::read_polylines(options.cage);
    if (!polylines.empty()) return subdivide_polylines(run, options, std::move(polylines));
    if (options.common.command->count("--scheme") > 0)
        throw base::UsageError("--scheme is for polylines, and " + options.cage +
                               " holds faces, which are refined as Catmull and Clark do");
    const mesh::Cage cage = read_cage(run, options.cage, base::LengthUnit::Millimetre);
    run.end_stage("read");
    refuse_levels(cage.topology->corner_count() * std::pow(4.0, options.levels - 1), "faces",
                  options.levels);
    const mesh::Cage fine = subd::refine(cage, options.levels);
    run.end_stage("subdivide");
    write_cage(run, fine, options.output, base::LengthUnit::Millimetre);
    run.report.cage = mesh::summarise(*fine.topology);
    run.end_stage("write");
    if (shows_anything(run, options.view))
        add_drawing(run, options.view, report::draw_mesh(fine), "The control mesh");
    return run.finish();
}

}  // namespace

void register_subdivide(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<SubdivideOptions>();
    CLI::App* command = app.add_subcommand(
        "subdivide", "Catmull-Clark steps on a cage, or steps of a curve scheme on polylines");
    command->add_option("cage", options->cage, "control mesh, or polylines and no faces (OBJ)")
        ->required();
    command->add_option("-n", options->levels, "number of steps")
        ->check(number_in(0, 12))
        ->capture_default_str();
    command->add_option("-o,--output", options->output, "refined control mesh or polylines (OBJ)")
        ->required();
    using subd::CurveScheme;
    add_choice<CurveScheme>(*command, "--scheme", options->scheme,
                            {{"edge-split", CurveScheme::CubicEdgeSplit},
                             {"corner-cutting", CurveScheme::CornerCutting},
                             {"de-rham", CurveScheme::DeRham}},
                            "of polylines: edge-split (to cubic B-splines, as creases do), "
                            "corner-cutting (at 1/4 and 3/4 of edges, Chaikin, to quadratic "
                            "B-splines) or de-rham (at 1/3 and 2/3)");
    add_picture_options(*command, options->view);
    add_common_options(*command, options->common, false);
    command->callback([options, &exit_code] {
        exit_code = about_input(options->cage, [&] { return subdivide(*options); });
    });
}

}  // namespace patchwright::cli
