#include "checks.h"
#include "view.h"

#include <patchwright/base/error.h>
#include <patchwright/subd/refine.h>

#include <fmt/format.h>

#include <memory>

namespace patchwright::cli {

namespace {

constexpr double max_faces = 2e7;

struct SubdivideOptions {
    CommonOptions common;
    ViewArguments view{.layer = report::PictureLayer::Patches};
    std::string cage, output;
    int levels = 1;
};

int subdivide(const SubdivideOptions& options) {
    Run run(options.common, {{options.cage},
                             {{"--output", options.output, OutputKind::Cage},
                              {"--picture", options.view.picture, OutputKind::Picture}}});
    const mesh::Cage cage = read_cage(run, options.cage, base::LengthUnit::Millimetre);
    run.end_stage("read");
    const double faces = cage.topology->corner_count() * std::pow(4.0, options.levels - 1);
    if (faces > max_faces) {
        throw base::UsageError(
            fmt::format("{} levels would make {:.3g} faces; use fewer", options.levels, faces));
    }
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
    CLI::App* command = app.add_subcommand("subdivide", "Catmull-Clark steps on a cage");
    command->add_option("cage", options->cage, "control mesh (OBJ)")->required();
    command->add_option("-n", options->levels, "number of steps")
        ->check(number_in(0, 12))
        ->capture_default_str();
    command->add_option("-o,--output", options->output, "refined control mesh (OBJ)")->required();
    add_picture_options(*command, options->view);
    add_common_options(*command, options->common, false);
    command->callback([options, &exit_code] {
        exit_code = about_input(options->cage, [&] { return subdivide(*options); });
    });
}

}  // namespace patchwright::cli
