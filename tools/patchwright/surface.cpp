#include "surface.h"

#include "options.h"

#include <patchwright/occ/assemble.h>
#include <patchwright/subd/normal_control.h>

#include <fmt/format.h>

#include <memory>

namespace patchwright::cli {

occ::CadModel write_surface(Run& run, const mesh::Cage& cage, const std::string& file,
                            const convert::ShapeOptions& making, double tolerance_mm,
                            const std::optional<measure::Failures>& bad_grid_cells) {
    const convert::Shape shape =
        convert::make_shape(subd::control_normals(cage), making, {tolerance_mm, tolerance_mm});
    for (const std::string& text : shape.notices) run.notice(text);
    run.end_stage("patch");
    const auto pending = std::make_shared<base::PendingFile>(file);
    occ::CadModel written = convert::write_and_read_back(shape, *pending, making.write);
    run.outputs.add(pending);
    run.end_stage("write");
    const convert::ShapeFigures figures =
        convert::inspect_shape(shape, written, file, run.progress());
    if (const auto text = convert::crossing_notice(figures)) run.notice(*text);
    run.report.patches = shape.patches;
    run.report.solid = figures.solid;
    run.report.continuity = figures.continuity;
    measure::VerdictFigures assessed = convert::verdict_figures(figures, shape.closed);
    assessed.bad_grid_cells = bad_grid_cells;
    run.report.verdict = measure::assess(assessed);
    run.end_stage("check");
    return written;
}

void add_surface_tolerance(CLI::App& command, std::string& tolerance) {
    command
        .add_option("--tolerance", tolerance,
                    fmt::format("of --cad-out: largest distance from the limit surface, which is "
                                "exact away from extraordinary vertices: {}",
                                length_help))
        ->check(is_length())
        ->capture_default_str();
}

void write_moved_surface(Run& run, const mesh::Cage& cage, const MovedSurface& surface) {
    const geom::Box3 box = geom::bounding_box(cage.points);
    occ::check_size(box, surface.cause);
    convert::ShapeOptions making;
    making.write.unit = run.report.unit;
    write_surface(run, cage, surface.file, making, length_mm(surface.tolerance, box.diagonal()),
                  surface.bad_grid_cells);
}

}  // namespace patchwright::cli
