#include "command.h"

#include <patchwright/occ/inspect_closely.h>

#include <cmath>
#include <memory>

namespace patchwright::cli {

namespace {

struct InspectOptions {
    CommonOptions common;
    std::string file, input_unit;
    double sharp_angle_deg = 20.0;
    bool no_heal = false;
};

report::DetailFigures detail_figures(const Input& input, const occ::CloseInspection& i) {
    return {.smallest_face = i.smallest_face,
            .narrowest_face = i.narrowest_face,
            .smallest_area = i.smallest_area_mm2,
            .narrowest_width = i.narrowest_width_mm,
            .shortest_edge = i.shortest_edge_mm,
            .shortest_edge_at = i.shortest_edge_at,
            .vertex_tolerance = i.vertex_tolerance_mm,
            .edge_tolerance = i.edge_tolerance_mm,
            .face_tolerance = i.face_tolerance_mm,
            .smallest_open_gap = i.smallest_open_gap_mm,
            .largest_open_gap = i.largest_open_gap_mm,
            .sharp_edges = i.sharp_edges,
            .smooth_edges = i.smooth_edges,
            .sharp_curves = i.sharp_curves,
            .free_curves = i.free_curves,
            .corners = i.corners,
            .kinked_faces = i.kinked_faces,
            .largest_kink_rad = i.largest_kink_rad,
            .largest_kink_at = i.largest_kink_at,
            .centre_of_mass = i.centre_of_mass,
            .principal_moments = i.principal_moments,
            .moments_of_volume = input.figures.solids > 0,
            .named_faces = i.named_faces,
            .coloured_faces = i.coloured_faces,
            .overlapping_solids = i.overlapping_solids,
            .duplicates_dropped = input.read.duplicates_dropped,
            .slivers_dropped = input.read.slivers_dropped,
            .faces_turned = input.read.faces_turned};
}

int inspect(const InspectOptions& options) {
    Run run(options.common);
    const Input input = read_input(run, options.file, options.input_unit, !options.no_heal);
    run.report.solid = input.figures;
    run.report.details = detail_figures(
        input, occ::inspect_closely(input.model,
                                    {.sharp_angle_rad = options.sharp_angle_deg * M_PI / 180.0,
                                     .progress = run.progress()}));
    run.end_stage("check");
    run.finish();
    return Done;
}

}  // namespace

void register_inspect(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<InspectOptions>();
    CLI::App* command =
        app.add_subcommand("inspect", "what is in a CAD file, after reading and sewing");
    command->add_option("file", options->file, "CAD file: STEP, IGES or BREP")->required();
    command->add_option("--input-unit", options->input_unit,
                        "overrides the unit written in the file");
    command->add_flag("--no-heal", options->no_heal,
                      "as it is in the file: nothing sewn or turned");
    command
        ->add_option("--sharp-angle", options->sharp_angle_deg,
                     "edges whose faces differ by more than this are sharp, degrees")
        ->check(CLI::Range(0.1, 179.0))
        ->capture_default_str();
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = inspect(*options); });
}

}  // namespace patchwright::cli
