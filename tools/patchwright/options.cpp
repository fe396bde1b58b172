#include "options.h"

#include <fmt/format.h>

#include <cmath>

namespace patchwright::cli {

namespace {

/// Of a cage: what fits into memory.
constexpr int most_faces = 1'000'000;
constexpr double longest_time_limit_s = 1e7;  // a season; clocks count it

/// @param ratio  the cage's diagonal by the model's
void note_cage_size(Run& run, const std::string& file, base::LengthUnit unit, double ratio) {
    constexpr double least = 0.5, largest = 2.0;
    if (ratio >= least && ratio <= largest) return;
    const auto likely = base::likely_unit(base::millimetres_per(unit) / ratio);
    const std::string advice = likely ? fmt::format("its unit is likely {0}: pass --cage-unit {0}",
                                                    base::short_name(*likely))
                                      : std::string("no other --cage-unit makes them alike");
    run.notice(
        fmt::format("{}: the cage is {:.3g} times as large as the model; {}", file, ratio, advice));
}

}  // namespace

void add_input_options(CLI::App& command, InputOptions& options) {
    command
        .add_option("--input-unit", options.unit,
                    "overrides the unit written in the input; STL and OBJ have none: mm")
        ->check(is_unit());
    command.add_flag("--allow-loss", options.allow_loss,
                     "CAD: go on without the faces that cannot be transferred");
    command
        .add_option("--read-limit", options.read_limit_s,
                    "CAD: seconds of processor time for reading and sewing; by default 15, and 15 "
                    "for each MB of the file")
        ->check(positive_up_to(longest_time_limit_s));
    command
        .add_option("--sharp-angle", options.sharp_angle_deg,
                    "edges whose faces differ by more than this are sharp, degrees; by default 20, "
                    "for triangles 35")
        ->check(number_in(0.1, 179.0));
}

void add_foot_point_option(CLI::App& command, InputOptions& options) {
    using occ::FootPoints;
    add_choice<FootPoints>(
        command, "--foot-points", options.foot_points,
        {{"search", FootPoints::Search}, {"kernel", FootPoints::Kernel}},
        "CAD: what finds nearest points: search, or the CAD kernel's extrema (kernel: another "
        "opinion, tens of times slower)");
}

occ::ReaderProcess& reader_process() {
    static occ::ReaderProcess process;
    return process;
}

convert::SourceOptions source_options(const InputOptions& options) {
    convert::SourceOptions reading{.allow_loss = options.allow_loss,
                                   .foot_points = options.foot_points,
                                   .reader = &reader_process(),
                                   .limits = {.time_s = options.read_limit_s}};
    if (!options.unit.empty()) reading.unit = base::parse_length_unit(options.unit);
    if (options.sharp_angle_deg) reading.sharp_angle_rad = *options.sharp_angle_deg * M_PI / 180.0;
    return reading;
}

convert::Source read_source(Run& run, const std::string& file, const InputOptions& options,
                            const ReadingOptions& needed) {
    convert::SourceOptions reading = source_options(options);
    reading.heal = needed.heal;
    reading.with_surface = needed.with_surface;
    reading.progress = needed.progress ? needed.progress : run.progress();
    convert::Source source = convert::read_source(file, reading);
    for (const std::string& text : source.notices) run.notice(text);
    run.report.input = source.input;
    run.report.unit = source.input.unit;
    run.end_stage("read");
    return source;
}

void add_cage_options(CLI::App& command, CageArguments& options) {
    using cage::Method;
    add_choice<Method>(
        command, "--layout", options.method,
        {{"aligned", Method::Aligned}, {"remesh", Method::Remesh}, {"auto", Method::Auto}},
        "how a cage is made: aligned (blocks along the lines of a wing, of a cross field or of the "
        "faces), remesh "
        "(any shape, more patches), or auto (aligned where it is found)");
    command
        .add_option("--target-faces", options.target_faces,
                    "number of faces to aim at, roughly; by default as the shape asks for")
        ->check(number_in(1, most_faces));
}

namespace {

void add_refinement_options(CLI::App& command, FitArguments& options) {
    using fit::RefinementScope;
    command
        .add_option("--max-levels", options.max_levels,
                    "refinements of the cage at most; by default 12, of remeshed cages 2")
        ->check(number_in(0, 20));
    add_choice<RefinementScope>(
        command, "--refine", options.refinement,
        {{"local", RefinementScope::Local}, {"global", RefinementScope::Global}},
        "where the cage is too coarse: local (strips of quads there are split lengthwise) or "
        "global (every face in four, as remeshed cages always are)");
    add_choice<mesh::CreaseRule>(
        command, "--crease-rule", options.crease_rule,
        {{"catmull-clark", mesh::CreaseRule::CatmullClark},
         {"runout", mesh::CreaseRule::ParabolicRunout}},
        "how the surface ends at sharp edges and borders: catmull-clark, or runout, nearer to "
        "curved models there (parabolic; other programs show such cages a little off); by default "
        "as the cage's file says, else catmull-clark");
}

}  // namespace

void add_fit_options(CLI::App& command, FitArguments& options, bool refines) {
    using fit::Symmetry;
    command
        .add_option("--tolerance", options.tolerance,
                    fmt::format("largest deviation: {}", length_help))
        ->check(is_length())
        ->capture_default_str();
    command
        .add_option("--cage-unit", options.cage_unit,
                    "unit of the cage's numbers: mm, cm, m, in, ft")
        ->check(is_unit())
        ->capture_default_str();
    if (refines) add_refinement_options(command, options);
    add_choice<Symmetry>(command, "--symmetry", options.symmetry,
                         {{"detect", Symmetry::Detect},
                          {"x", Symmetry::X},
                          {"y", Symmetry::Y},
                          {"z", Symmetry::Z},
                          {"none", Symmetry::None}},
                         "plane that a half model ends on: x, y or z (where that coordinate is 0), "
                         "detect or none");
    CLI::Option* limit =
        command
            .add_option("--time-limit", options.time_limit_s,
                        "seconds; then the best result so far is checked and delivered")
            ->check(positive_up_to(longest_time_limit_s));
    if (options.time_limit_s) limit->default_str(fmt::format("{:g}", *options.time_limit_s));
}

convert::ConvertOptions convert_options(Run& run, const convert::Source& source,
                                        const FitArguments& fit, const CageArguments& cage,
                                        const std::string& cage_file) {
    convert::ConvertOptions options{.tolerance_mm = length_mm(fit.tolerance, source.input.diagonal),
                                    .method = cage.method,
                                    .target_faces = cage.target_faces,
                                    .refinement = fit.refinement,
                                    .symmetry = fit.symmetry,
                                    .crease_rule = fit.crease_rule,
                                    .max_levels = fit.max_levels};
    if (!cage_file.empty()) {
        const auto unit = base::parse_length_unit(fit.cage_unit);
        options.cage = read_cage(run, cage_file, unit);
        note_cage_size(run, cage_file, unit,
                       geom::bounding_box(options.cage->points).diagonal() / source.input.diagonal);
    }
    note_chord_error(run, source, options.tolerance_mm);
    return options;
}

void leave_out_narrow_holes(Run& run, convert::Source& source, double tolerance_mm) {
    for (const std::string& text : convert::leave_out_narrow_holes(source, tolerance_mm))
        run.notice(fmt::format("{}: {}", source.input.file, text));
    run.report.input = source.input;
}

void refuse_control_mesh(const convert::Source& source) {
    if (!source.is_control_mesh) return;
    throw base::InputError(
        fmt::format("{}: this is a control mesh, as its tags tell: use export, or --cage for it",
                    source.input.file));
}

CLI::Option* add_normal_tolerance_option(CLI::App& command, std::string& normal_tolerance) {
    return command
        .add_option("--normal-tolerance", normal_tolerance,
                    "largest angle between the normals of output and input, beyond 0.002 of the "
                    "diagonal from the input's edges, such as 0.5deg, else the exit code is 3; by "
                    "default no limit but the 45 degrees of folds")
        ->check(is_angle());
}

std::optional<double> normal_tolerance_rad(const std::string& normal_tolerance) {
    if (normal_tolerance.empty()) return std::nullopt;
    return base::parse_angle(normal_tolerance);
}

double length_mm(const std::string& text, double diagonal_mm) {
    return base::parse_length(text).in_millimetres(diagonal_mm);
}

void note_chord_error(Run& run, const convert::Source& source, double tolerance_mm) {
    if (!source.mesh || source.mesh->chord_error() <= tolerance_mm) return;
    const double error = source.mesh->chord_error(), scale = base::millimetres_per(run.report.unit);
    run.notice(
        fmt::format("the triangles are up to about {:.2g} {} from the rounded surface they stand "
                    "for, more than the tolerance of {:.2g}: their facets will be followed; "
                    "--tolerance {:.2g}{} is what they can tell",
                    error / scale, base::short_name(run.report.unit), tolerance_mm / scale,
                    2.0 * error / scale, base::short_name(run.report.unit)));
}

void add_output_options(CLI::App& command, OutputOptions& options) {
    using convert::Colouring;
    using occ::StepSchema;
    using patch::Covering;
    using patch::Join;
    convert::ShapeOptions& shape = options.shape;
    command
        .add_option("-o,--output", options.file, "CAD file to write: .step .stp .igs .iges .brep")
        ->required();
    command.add_option("--unit", options.unit, "unit of the output: mm, cm, m, in, ft or input")
        ->check(is_unit_or_input())
        ->capture_default_str();
    add_choice<StepSchema>(
        command, "--schema", shape.write.schema,
        {{"ap203", StepSchema::Ap203}, {"ap214", StepSchema::Ap214}, {"ap242", StepSchema::Ap242}},
        "STEP schema: ap203, ap214 or ap242");
    add_choice<Join>(command, "--continuity", shape.join,
                     {{"g1", Join::G1}, {"refined", Join::Refined}},
                     "at extraordinary vertices: g1 (tangent planes agree exactly) or refined "
                     "(knots towards the vertex, a small kink remains)");
    add_choice<Covering>(
        command, "--patches", shape.covering,
        {{"charts", Covering::Charts}, {"faces", Covering::Faces}},
        "charts (one surface for as many cage faces as possible) or faces (one each)");
    add_choice<Colouring>(
        command, "--color", shape.colouring,
        {{"none", Colouring::None}, {"kind", Colouring::Kind}, {"deviation", Colouring::Deviation}},
        "faces in STEP: none, kind (blue: regular, orange: with an extraordinary "
        "corner), or deviation (from the input: blue 0, red the tolerance or "
        "more)");
    command.add_flag("--time-stamp", shape.write.time_stamp,
                     "write the time into the file, which then differs from run to run");
    command
        .add_option(
            "--cap-depth", shape.cap_depth,
            "knot levels towards an extraordinary vertex; by default as the tolerance needs")
        ->check(number_in(1, patch::max_cap_depth));
}

base::LengthUnit output_unit(const OutputOptions& options, base::LengthUnit input) {
    return options.unit == "input" ? input : base::parse_length_unit(options.unit);
}

}  // namespace patchwright::cli
