#include "fitting.h"

#include <memory>

namespace patchwright::cli {

namespace {

struct FitOnlyOptions {
    CommonOptions common;
    FitCommandOptions fit;
    LayoutOptions layout;
    InputOptions read;
    std::string input, cage, output;
};

int fit_only(const FitOnlyOptions& options) {
    const auto cage_unit = base::parse_length_unit(options.fit.cage_unit);
    base::parse_length(options.fit.tolerance);
    Run run(options.common);
    mesh::Cage cage;
    if (!options.cage.empty()) cage = read_cage(run, options.cage, cage_unit);
    Input input = read_input(run, options.input, options.read);
    prepare(run, input);
    const geom::ModelSurface& reference = input.reference();
    const double tolerance = relative_tolerance(options.fit, reference);
    note_chord_error(run, input, tolerance * reference.bounds().diagonal());
    FitCommandOptions fit = options.fit;
    std::optional<PartFits> parts;
    if (options.cage.empty()) {
        cage::CageResult made = make_cage(run, input, options.layout, tolerance);
        cage = std::move(made.cage);
        fit = for_made_cage(fit, made);
        parts = part_fits(run, input);
    }
    run.end_stage("layout");
    const mesh::Cage fitted = fit_cage(run, cage, reference, fit, parts ? &*parts : nullptr);
    write_cage(fitted, options.output, cage_unit);
    run.end_stage("write");
    run.finish();
    return run.report.fit->met ? Done : ToleranceMissed;
}

}  // namespace

void register_fit(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<FitOnlyOptions>();
    CLI::App* command =
        app.add_subcommand("fit", "fit a cage to a CAD file, write the fitted cage");
    command->add_option("input", options->input, input_help)->required();
    command->add_option("--cage", options->cage,
                        "control mesh (OBJ); left away: made from the CAD");
    command->add_option("-o,--output", options->output, "fitted control mesh (OBJ)")->required();
    add_input_options(*command, options->read);
    add_layout_options(*command, options->layout);
    add_fit_options(*command, options->fit);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = fit_only(*options); });
}

}  // namespace patchwright::cli
