#include "command.h"
#include "options.h"

#include <patchwright/base/error.h>
#include <patchwright/convert/family.h>
#include <patchwright/fit/modes.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <set>
#include <string_view>

namespace patchwright::cli {

namespace {

using convert::FamilyMember;

/// In --output: the name of a design's file, without folder and extension.
constexpr std::string_view design_placeholder = "{name}";
constexpr int most_modes = 1000;

struct FamilyCommandOptions {
    CommonOptions common;
    FitArguments fit;
    InputOptions read;
    std::string cage_file, earlier, output, modes_out;
    std::vector<std::string> designs;
    std::optional<int> modes;
};

/// One file a design: the output's name with the design's in place of {name}.
std::vector<std::string> output_files(const FamilyCommandOptions& options) {
    if (options.output.find(design_placeholder) == std::string::npos)
        throw base::UsageError(fmt::format(
            "--output {}: has no {} for the names of the designs, as in 'fitted/{}.obj'",
            options.output, design_placeholder, design_placeholder));
    std::vector<std::string> files;
    std::set<std::string> known;
    for (const std::string& design : options.designs) {
        std::string file = named(options.output, design_placeholder,
                                 std::filesystem::path(design).stem().string());
        if (!known.insert(file).second)
            throw base::UsageError(
                fmt::format("two designs would be written to {}; rename one of them", file));
        files.push_back(std::move(file));
    }
    return files;
}

RunFiles files_of(const FamilyCommandOptions& options, const std::vector<std::string>& outputs) {
    RunFiles files{options.designs, {}};
    files.inputs.push_back(options.cage_file);
    files.inputs.push_back(options.earlier);
    for (const std::string& file : outputs)
        files.outputs.push_back({"--output", file, OutputKind::Cage});
    files.outputs.push_back({"--modes-out", options.modes_out, OutputKind::Table});
    return files;
}

std::vector<FamilyMember> fit_designs(Run& run, const FamilyCommandOptions& options,
                                      const mesh::Cage& cage) {
    const base::Budget budget = run.budget(options.fit.time_limit_s);
    std::optional<convert::Source> earlier;
    if (!options.earlier.empty()) {
        convert::SourceOptions reading = source_options(options.read);
        reading.progress = budget.limited();
        earlier = about_input(options.earlier,
                              [&] { return convert::read_source(options.earlier, reading); });
        for (const std::string& text : earlier->notices) run.notice(text);
        run.end_stage("read");
    }
    convert::FamilyOptions fitting{.tolerance = base::parse_length(options.fit.tolerance),
                                   .symmetry = options.fit.symmetry,
                                   .reading = source_options(options.read),
                                   .earlier = earlier ? &*earlier : nullptr};
    const std::vector<std::filesystem::path> designs(options.designs.begin(),
                                                     options.designs.end());
    std::vector<FamilyMember> members = convert::fit_family(cage, designs, fitting, budget);
    for (const FamilyMember& member : members)
        for (const std::string& text : member.notices)
            run.notice(text.find(member.file.string()) == std::string::npos
                           ? member.file.string() + ": " + text
                           : text);
    run.end_stage("fit");
    return members;
}

/// The figures of each design, and the verdict on all of them.
void add_figures(Run& run, const std::vector<FamilyMember>& members) {
    report::FamilyFigures& family = run.report.family.emplace();
    measure::VerdictFigures figures{.missed_designs = measure::Failures(),
                                    .designs = int(members.size())};
    for (const FamilyMember& member : members) {
        report::FamilyFigures::Member& told = family.members.emplace_back();
        told.file = member.file.string();
        told.tolerance = member.tolerance_mm;
        told.seconds = member.seconds;
        told.sentence = "MISSED: no result within the time limit; try a longer --time-limit";
        figures.stopped_by_time_limit = figures.stopped_by_time_limit || !member.attempt ||
                                        member.attempt->stopped_by_time_limit;
        if (member.attempt) {
            const measure::Verdict& verdict = member.attempt->verdict;
            told.met = verdict.met();
            told.sentence = verdict.sentence(run.report.unit);
            const report::FitFigures& fit = member.attempt->fit;
            told.distance = fit.levels[std::size_t(fit.best_level)].largest();
        }
        figures.missed_designs->count += told.met ? 0 : 1;
    }
    run.report.verdict = measure::assess(figures);
}

/// Mean and modes of control points, a row each.
std::string csv(const fit::Modes& modes, double unit) {
    std::string text = "x,y,z";
    for (int k = 1; k <= modes.count(); ++k)
        fmt::format_to(std::back_inserter(text), ",dx{0},dy{0},dz{0}", k);
    text += "\n";
    for (Eigen::Index i = 0; i < modes.mean.rows(); ++i) {
        fmt::format_to(std::back_inserter(text), "{},{},{}", modes.mean(i, 0) / unit,
                       modes.mean(i, 1) / unit, modes.mean(i, 2) / unit);
        for (const geom::Points& shape : modes.shapes)
            fmt::format_to(std::back_inserter(text), ",{},{},{}", shape(i, 0), shape(i, 1),
                           shape(i, 2));
        text += "\n";
    }
    return text;
}

void add_modes(Run& run, const FamilyCommandOptions& options, const mesh::Cage& cage,
               const std::vector<FamilyMember>& members) {
    std::vector<geom::Points> shapes;
    std::vector<std::size_t> fitted;
    for (std::size_t i = 0; i < members.size(); ++i) {
        if (!members[i].attempt) continue;
        fitted.push_back(i);
        shapes.push_back(members[i].attempt->fitted.points);
    }
    if (shapes.size() < 2) {
        run.notice("fewer than two designs were fitted: there are no modes");
        return;
    }
    const fit::Modes modes = fit::principal_modes(cage.topology, shapes, *options.modes);
    if (modes.count() < *options.modes)
        run.notice(fmt::format("the designs have {} modes; there are no more", modes.count()));
    report::FamilyFigures& family = *run.report.family;
    for (int k = 0; k < modes.count(); ++k)
        family.modes.push_back({modes.deviations_mm[std::size_t(k)], modes.share(k + 1)});
    for (std::size_t i = 0; i < fitted.size(); ++i) {
        const Eigen::VectorXd weights = modes.weights.row(Eigen::Index(i));
        report::FamilyFigures::Member& told = family.members[fitted[i]];
        told.weights.assign(weights.begin(), weights.end());
        told.off_modes = (fit::member(modes, weights) - shapes[i]).rowwise().norm().maxCoeff();
    }
    if (!options.modes_out.empty())
        run.outputs.add(
            options.modes_out,
            csv(modes, base::millimetres_per(base::parse_length_unit(options.fit.cage_unit))));
    run.end_stage("modes");
}

int fit_family(const FamilyCommandOptions& options) {
    if (!options.modes_out.empty() && !options.modes)
        throw base::UsageError("--modes-out needs --modes, their number");
    const std::vector<std::string> outputs = output_files(options);
    Run run(options.common, files_of(options, outputs));
    run.report.unit = base::parse_length_unit(options.fit.cage_unit);
    const mesh::Cage cage = about_input(
        options.cage_file, [&] { return read_cage(run, options.cage_file, run.report.unit); });
    run.end_stage("read");
    const std::vector<FamilyMember> members = fit_designs(run, options, cage);
    add_figures(run, members);
    if (options.modes) add_modes(run, options, cage, members);
    for (std::size_t i = 0; i < members.size(); ++i)
        if (members[i].attempt)
            write_cage(run, members[i].attempt->fitted, outputs[i], run.report.unit);
    run.end_stage("write");
    return run.finish();
}

}  // namespace

void register_family(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<FamilyCommandOptions>();
    CLI::App* command = app.add_subcommand(
        "family", "fit a fitted cage to many designs, and find the modes they differ by");
    command->add_option("cage", options->cage_file, "fitted control mesh (OBJ)")->required();
    command->add_option("designs", options->designs, input_help)->required();
    command
        ->add_option("-o,--output", options->output,
                     "control meshes of the designs (OBJ), with {name} for the names of their "
                     "files, as in 'fitted/{name}.obj'")
        ->required();
    command->add_option("--from", options->earlier,
                        "what the cage was fitted to, with the same faces as the designs: points "
                        "go with these, as in refit");
    command
        ->add_option("--modes", options->modes,
                     "find so many principal components of the control points")
        ->check(number_in(1, most_modes));
    command->add_option("--modes-out", options->modes_out,
                        "write them for the subcommand member: x,y,z of the mean's control "
                        "points, then dx,dy,dz of each mode");
    add_input_options(*command, options->read);
    add_fit_options(*command, options->fit, false);
    add_common_options(*command, options->common, true);
    command->callback([options, &exit_code] { exit_code = fit_family(*options); });
}

}  // namespace patchwright::cli
