#include "runs.h"

#include "cage.h"
#include "call.h"
#include "model.h"
#include "options.h"

#include <patchwright/base/stage_clock.h>
#include <patchwright/convert/figures.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/subd/normal_control.h>

#include <pybind11/stl.h>
#include <sys/resource.h>

#include <filesystem>

namespace patchwright::python {

namespace {

namespace fs = std::filesystem;

constexpr double longest_s = 1e7;  // a season; clocks count it
constexpr int most_samples = 10'000'000, most_faces = 1'000'000, most_levels = 20;

double length_mm(const Options& options, const char* name, double diagonal_mm) {
    return base::parse_length(options.text(name).value_or("1e-4rel")).in_millimetres(diagonal_mm);
}

int samples_of(const Options& options) {
    return options.integer("samples", 1, most_samples).value_or(convert::ConvertOptions{}.samples);
}

/// The report's JSON, and the command line's text.
py::tuple finish(report::RunReport& report) {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    report.peak_memory_mb = double(usage.ru_maxrss) / 1024.0;
    return py::make_tuple(report::to_json(report),
                          report::to_text(report, report::TextDetail::Brief));
}

/// The unit of files to be written.
base::LengthUnit output_unit(const Options& options, base::LengthUnit input) {
    const std::string unit = options.text("unit").value_or("input");
    return unit == "input" ? input : base::parse_length_unit(unit);
}

convert::ShapeOptions shape_options(const Options& options) {
    using convert::Colouring;
    using occ::StepSchema;
    convert::ShapeOptions shape{
        .join = options.choice<patch::Join>(
            "continuity", {{"g1", patch::Join::G1}, {"refined", patch::Join::Refined}}),
        .covering = options.choice<patch::Covering>(
            "patches", {{"charts", patch::Covering::Charts}, {"faces", patch::Covering::Faces}}),
        .cap_depth = options.integer("cap_depth", 1, patch::max_cap_depth),
        .colouring = options.choice<Colouring>("color", {{"none", Colouring::None},
                                                         {"kind", Colouring::Kind},
                                                         {"deviation", Colouring::Deviation}})};
    shape.write.schema = options.choice<StepSchema>(
        "schema",
        {{"ap214", StepSchema::Ap214}, {"ap203", StepSchema::Ap203}, {"ap242", StepSchema::Ap242}});
    return shape;
}

cage::Method layout_of(const Options& options) {
    using cage::Method;
    return options.choice<Method>(
        "layout",
        {{"auto", Method::Auto}, {"aligned", Method::Aligned}, {"remesh", Method::Remesh}});
}

/// None: no limit.
std::optional<double> normal_tolerance_rad(const Options& options) {
    const std::optional<std::string> given = options.text("normal_tolerance");
    if (!given) return std::nullopt;
    return base::parse_angle(*given);
}

/// Nothing where the cage's own is to stay.
std::optional<mesh::CreaseRule> crease_rule_of(const Options& options) {
    using mesh::CreaseRule;
    if (!options.text("crease_rule")) return std::nullopt;
    return options.choice<CreaseRule>("crease_rule", {{"catmull-clark", CreaseRule::CatmullClark},
                                                      {"runout", CreaseRule::ParabolicRunout}});
}

convert::ConvertOptions convert_options(const Options& options, const convert::Source& source,
                                        const std::optional<mesh::Cage>& cage) {
    using fit::RefinementScope;
    using fit::Symmetry;
    return {.tolerance_mm = length_mm(options, "tolerance", source.input.diagonal),
            .normal_tolerance_rad = normal_tolerance_rad(options),
            .cage = cage,
            .method = layout_of(options),
            .target_faces = options.integer("target_faces", 1, most_faces),
            .refinement = options.choice<RefinementScope>(
                "refine", {{"local", RefinementScope::Local}, {"global", RefinementScope::Global}}),
            .symmetry = options.choice<Symmetry>("symmetry", {{"detect", Symmetry::Detect},
                                                              {"x", Symmetry::X},
                                                              {"y", Symmetry::Y},
                                                              {"z", Symmetry::Z},
                                                              {"none", Symmetry::None}}),
            .crease_rule = crease_rule_of(options),
            .max_levels = options.integer("max_levels", 0, most_levels)};
}

base::Budget budget_of(const Options& options, base::Progress progress) {
    const std::optional<double> limit = options.number("time_limit", 1e-9, longest_s);
    if (!limit) return base::Budget(std::nullopt, std::move(progress));
    return base::Budget(base::Budget::Seconds(*limit), std::move(progress));
}

/// The model that a cage is made of.
convert::Source source_of_cage(const PyModel& model, double tolerance_mm) {
    convert::Source source = *model.source;
    const auto texts = convert::leave_out_narrow_holes(source, tolerance_mm);
    source.notices.insert(source.notices.end(), texts.begin(), texts.end());
    return source;
}

report::RunReport report_of(const convert::Source& source, const Options& options,
                            const std::string& command) {
    return {.unit = source.input.unit,
            .options = options.listed(command),
            .input = source.input,
            .notices = source.notices};
}

void refuse_control_mesh(const convert::Source& source) {
    if (source.is_control_mesh)
        throw base::InputError(source.input.file +
                               ": this is a control mesh, as its tags tell: use export, or read it "
                               "as a Cage");
}

/// @throw UsageError, OutputError when no CAD file can be written there
void check_output(const fs::path& output) {
    try {
        occ::file_format(output);
    } catch (const base::InputError& error) {
        throw base::UsageError(error.what());
    }
    base::OutputTarget{output};
}

std::optional<mesh::Cage> cage_of(const std::optional<PyCage>& cage) {
    return cage ? std::optional(cage->checked()) : std::nullopt;
}

/// Of a run: how long its stages took and what it had to tell.
void add_course(report::RunReport& report, const convert::Conversion& done) {
    report.seconds = done.seconds;
    report.notices.insert(report.notices.end(), done.notices.begin(), done.notices.end());
}

py::tuple convert_model(const PyModel& model, const fs::path& output,
                        const std::optional<PyCage>& given, const py::dict& named,
                        py::object progress) {
    const Options options(named);
    refuse_control_mesh(*model.source);
    check_output(output);
    convert::ConvertOptions converting = convert_options(options, *model.source, cage_of(given));
    const convert::Source source =
        given ? *model.source : source_of_cage(model, converting.tolerance_mm);
    report::RunReport report = report_of(source, options, "convert");
    converting.shape = shape_options(options);
    report.unit = converting.shape.write.unit = output_unit(options, source.input.unit);
    converting.samples = samples_of(options);
    Call call(std::move(progress));
    const base::Budget budget = budget_of(options, call.progress());
    base::OutputSet outputs;
    const convert::Conversion done = call.run(source.input.file, [&] {
        return convert::convert(source, output, outputs, converting, budget);
    });
    if (!done.kept) throw base::TimeLimitReached();
    const convert::Attempt& best = done.attempts[*done.kept];
    convert::add_attempt(report, best);
    add_course(report, done);
    call.run(source.input.file, [&] {
        outputs.commit();
        return 0;
    });
    const py::tuple told = finish(report);
    return py::make_tuple(told[0], told[1], PyCage(best.fitted));
}

py::tuple fit_model(const PyModel& model, const std::optional<PyCage>& given, const py::dict& named,
                    py::object progress) {
    const Options options(named);
    refuse_control_mesh(*model.source);
    convert::ConvertOptions fitting = convert_options(options, *model.source, cage_of(given));
    const convert::Source source =
        given ? *model.source : source_of_cage(model, fitting.tolerance_mm);
    fitting.interpolate = options.flag("interpolate");
    report::RunReport report = report_of(source, options, "fit");
    Call call(std::move(progress));
    const base::Budget budget = budget_of(options, call.progress());
    const convert::Conversion done =
        call.run(source.input.file, [&] { return convert::fit_only(source, fitting, budget); });
    convert::add_fitted(report, done.attempts.front());
    add_course(report, done);
    const py::tuple told = finish(report);
    return py::make_tuple(told[0], told[1], PyCage(done.attempts.front().fitted));
}

py::tuple refit_model(const PyModel& model, const PyModel* earlier,
                      const std::optional<fs::path>& output, const PyCage& given,
                      const py::dict& named, py::object progress) {
    const Options options(named);
    const convert::Source& source = *model.source;
    refuse_control_mesh(source);
    if (output) check_output(*output);
    convert::ConvertOptions refitting = convert_options(options, source, given.checked());
    refitting.refit = true;
    refitting.earlier = earlier == nullptr ? nullptr : earlier->source.get();
    refitting.shape.write.unit = source.input.unit;
    report::RunReport report = report_of(source, options, "refit");
    Call call(std::move(progress));
    const base::Budget budget = budget_of(options, call.progress());
    base::OutputSet outputs;
    const convert::Conversion done = call.run(source.input.file, [&] {
        return output ? convert::convert(source, *output, outputs, refitting, budget)
                      : convert::fit_only(source, refitting, budget);
    });
    if (!done.kept) throw base::TimeLimitReached();
    const convert::Attempt& best = done.attempts[*done.kept];
    if (output)
        convert::add_attempt(report, best);
    else
        convert::add_fitted(report, best);
    add_course(report, done);
    call.run(source.input.file, [&] {
        outputs.commit();
        return 0;
    });
    const py::tuple told = finish(report);
    return py::make_tuple(told[0], told[1], PyCage(best.fitted));
}

py::tuple make_cage(const PyModel& model, const py::dict& named, py::object progress) {
    const Options options(named);
    refuse_control_mesh(*model.source);
    const double diagonal = model.source->input.diagonal;
    const double tolerance = length_mm(options, "tolerance", diagonal);
    const convert::Source source = source_of_cage(model, tolerance);
    cage::CageOptions making{.method = layout_of(options),
                             .target_faces = options.integer("target_faces", 1, most_faces),
                             .tolerance_rel = tolerance / diagonal};
    report::RunReport report = report_of(source, options, "cage");
    Call call(std::move(progress));
    making.progress = call.progress();
    base::StageClock clock;
    cage::CageResult made =
        call.run(source.input.file, [&] { return cage::make_cage(source.surface(), making); });
    clock.end("layout");
    report.cage = mesh::summarise(*made.cage.topology);
    report.layout = made.layout;
    report.seconds = clock.seconds();
    report.notices.insert(report.notices.end(), made.notices.begin(), made.notices.end());
    const py::tuple told = finish(report);
    return py::make_tuple(told[0], told[1], PyCage(std::move(made.cage)), made.layout);
}

void export_shape(const mesh::Cage& cage, const fs::path& output, double tolerance_mm,
                  const convert::ShapeOptions& making, report::RunReport& report,
                  const base::Progress& progress) {
    base::StageClock clock;
    occ::check_size(geom::bounding_box(cage.points), "cage");
    const convert::Shape shape =
        convert::make_shape(subd::control_normals(cage), making, {tolerance_mm, tolerance_mm});
    report.notices = shape.notices;
    clock.end("patch");
    const auto file = std::make_shared<base::PendingFile>(output);
    const occ::CadModel written = convert::write_and_read_back(shape, *file, making.write);
    base::OutputSet outputs;
    outputs.add(file);
    clock.end("write");
    const convert::ShapeFigures figures =
        convert::inspect_shape(shape, written, output.string(), progress);
    if (auto text = convert::crossing_notice(figures)) report.notices.push_back(std::move(*text));
    report.patches = shape.patches;
    report.solid = figures.solid;
    report.continuity = figures.continuity;
    report.verdict = measure::assess(convert::verdict_figures(figures, shape.closed));
    clock.end("check");
    report.seconds = clock.seconds();
    outputs.commit();
}

py::tuple export_cage(const PyCage& given, const fs::path& output, const py::dict& named,
                      py::object progress) {
    const Options options(named);
    check_output(output);
    const mesh::Cage cage = given.checked();
    convert::ShapeOptions making = shape_options(options);
    if (making.colouring == convert::Colouring::Deviation)
        throw base::UsageError(
            "color deviation needs an input to deviate from; use convert, or color kind");
    making.write.unit = output_unit(options, base::LengthUnit::Millimetre);
    report::RunReport report{.unit = making.write.unit,
                             .options = options.listed("export"),
                             .cage = mesh::summarise(*cage.topology)};
    const double tolerance =
        length_mm(options, "tolerance", geom::bounding_box(cage.points).diagonal());
    Call call(std::move(progress));
    call.run("cage", [&] {
        export_shape(cage, output, tolerance, making, report, call.progress());
        return 0;
    });
    return finish(report);
}

py::tuple compare_models(const PyModel& a, const PyModel& b, const py::dict& named,
                         py::object progress) {
    const Options options(named);
    const convert::Source &input = *a.source, &output = *b.source;
    report::RunReport report = report_of(input, options, "compare");
    report.solid = output.figures;
    std::optional<double> tolerance;
    if (options.text("tolerance"))
        tolerance = length_mm(options, "tolerance", input.input.diagonal);
    const int samples = samples_of(options);
    Call call(std::move(progress));
    call.run(input.input.file, [&] {
        base::StageClock clock;
        report::DeviationFigures deviation = convert::compare(output.surface(), input.surface(),
                                                              samples, tolerance, call.progress());
        convert::add_bounds(deviation, output.surface(), input.surface(), call.progress());
        if (tolerance)
            report.verdict = convert::assess(output, input, deviation, *tolerance,
                                             normal_tolerance_rad(options));
        report.deviation = std::move(deviation);
        clock.end("check");
        report.seconds = clock.seconds();
        return 0;
    });
    return finish(report);
}

py::tuple inspect_model(const PyModel& model, py::object progress) {
    const convert::Source& source = *model.source;
    report::RunReport report = report_of(source, Options(py::dict()), "inspect");
    report.solid = source.figures;
    Call call(std::move(progress));
    report.details = call.run(source.input.file,
                              [&] { return convert::inspect_closely(source, call.progress()); });
    return finish(report);
}

}  // namespace

void bind_runs(py::module_& module) {
    module.def("convert", convert_model);
    module.def("fit", fit_model);
    module.def("refit", refit_model);
    module.def("make_cage", make_cage);
    module.def("export", export_cage);
    module.def("compare", compare_models);
    module.def("inspect", inspect_model);
}

}  // namespace patchwright::python
