#include "input.h"

#include <patchwright/geom/mesh_figures.h>
#include <patchwright/mesh/read_triangles.h>
#include <patchwright/occ/inspect.h>

#include <fmt/format.h>

#include <cmath>

namespace patchwright::cli {

namespace {

Input read_model(Run& run, const std::string& file, const InputOptions& given) {
    occ::ReadOptions options{.heal = given.heal, .progress = run.progress()};
    if (!given.unit.empty()) options.unit = base::parse_length_unit(given.unit);
    const occ::ReadResult result = occ::read_cad(file, options);
    for (const std::string& text : result.report.notices) run.notice(text);
    Input input{
        .model = result.model, .figures = solid_figures(file, result.model), .read = result.report};
    // Blades and wings are not that small or large, but files whose unit is wrong are.
    constexpr double small_mm = 300.0, large_mm = 300e3;
    const double diagonal = input.figures.bounds.diagonal();
    if (given.unit.empty() && (diagonal < small_mm || diagonal > large_mm)) {
        run.notice(
            fmt::format("{}: the model is {:.3g} m across by its unit, {}; if that is wrong, "
                        "see --input-unit",
                        file, 1e-3 * diagonal, base::short_name(result.report.unit)));
    }
    constexpr const char* formats[] = {"STEP", "IGES", "BREP"};
    run.report.unit = result.report.unit;
    run.report.input =
        report::InputFigures{.file = file,
                             .format = formats[static_cast<int>(result.report.format)],
                             .schema = result.report.schema,
                             .originating_system = result.report.originating_system,
                             .unit = result.report.unit,
                             .solids = input.figures.solids,
                             .faces = input.figures.faces,
                             .free_edges = input.figures.free_edges,
                             .diagonal = input.figures.bounds.diagonal(),
                             .largest_gap_closed = result.report.largest_gap_mm,
                             .sewing_tolerance = result.report.sewing_tolerance_mm};
    return input;
}

report::SolidFigures mesh_figures(const std::string& file, const geom::MeshReference& reference,
                                  const geom::MeshRepair& repair) {
    const geom::TriangleMesh& mesh = reference.mesh();
    const int count = static_cast<int>(mesh.triangles.size());
    const bool closed = repair.free_sides == 0;
    const geom::MeshFigures figures = geom::measure_mesh(mesh, closed);
    return {.file = file,
            .solids = repair.closed_bodies - repair.hollows,
            .shells_closed = repair.closed_bodies,
            .shells_open = repair.bodies - repair.closed_bodies,
            .faces = count,
            .edges = figures.sides,
            .vertices = static_cast<int>(mesh.points.rows()),
            .free_edges = figures.free_sides,
            .faces_by_kind = {{"triangle", count}},
            .closed = closed,
            .valid = true,
            .volume = closed ? figures.volume : 0.0,
            .area = figures.area,
            .bounds = reference.bounds()};
}

Input read_mesh(Run& run, const std::string& file, const InputOptions& given) {
    const base::LengthUnit unit =
        given.unit.empty() ? base::LengthUnit::Millimetre : base::parse_length_unit(given.unit);
    mesh::TriangleFile result = mesh::read_triangles(file, base::millimetres_per(unit));
    for (const std::string& text : result.notices) run.notice(text);
    geom::MeshReferenceOptions options;
    if (given.sharp_angle_deg > 0.0) options.sharp_angle_rad = given.sharp_angle_deg * M_PI / 180.0;
    Input input;
    input.mesh = std::make_unique<geom::MeshReference>(std::move(result.mesh), options);
    input.repair = result.repair;
    input.figures = mesh_figures(file, *input.mesh, result.repair);
    const double diagonal = input.mesh->bounds().diagonal();
    if (given.unit.empty())
        run.notice(fmt::format(
            "{}: files of this kind hold no unit; read as mm it is {:.3g} m across; see "
            "--input-unit",
            file, 1e-3 * diagonal));
    run.report.unit = unit;
    run.report.input = report::InputFigures{.file = file,
                                            .format = result.format,
                                            .unit = unit,
                                            .solids = input.figures.solids,
                                            .faces = input.figures.faces,
                                            .free_edges = input.figures.free_edges,
                                            .diagonal = diagonal};
    return input;
}

}  // namespace

report::SolidFigures solid_figures(const std::string& file, const occ::CadModel& model) {
    const occ::Inspection i = occ::inspect(model);
    return {.file = file,
            .solids = i.solids,
            .shells_closed = i.shells_closed,
            .shells_open = i.shells_open,
            .faces = i.faces,
            .edges = i.edges,
            .vertices = i.vertices,
            .free_edges = i.free_edges,
            .nonmanifold_edges = i.nonmanifold_edges,
            .faces_by_kind = i.faces_by_kind,
            .closed = i.closed,
            .valid = i.valid,
            .all_bicubic = i.all_bicubic,
            .volume = i.volume_mm3,
            .area = i.area_mm2,
            .max_tolerance = i.max_tolerance_mm,
            .bounds = i.bounds};
}

void add_input_options(CLI::App& command, InputOptions& options) {
    command.add_option("--input-unit", options.unit,
                       "overrides the unit written in the input; STL and OBJ have none: mm");
    command
        .add_option("--sharp-angle", options.sharp_angle_deg,
                    "edges whose faces differ by more than this are sharp, degrees; left away: 20, "
                    "for triangles 35")
        ->check(CLI::Range(0.1, 179.0));
}

Input read_input(Run& run, const std::string& file, const InputOptions& options) {
    Input input = mesh::is_triangle_file(file) ? read_mesh(run, file, options)
                                               : read_model(run, file, options);
    input.sharp_angle_deg = options.sharp_angle_deg;
    run.end_stage("read");
    return input;
}

occ::ReferenceOptions reference_options(const Run& run, const Input& input) {
    occ::ReferenceOptions options{.progress = run.progress()};
    if (input.sharp_angle_deg > 0.0) options.sharp_angle_rad = input.sharp_angle_deg * M_PI / 180.0;
    return options;
}

void prepare(Run& run, Input& input) {
    if (!input.mesh)
        input.cad =
            std::make_unique<occ::CadReference>(*input.model, reference_options(run, input));
}

void note_chord_error(Run& run, const Input& input, double tolerance_mm) {
    if (!input.mesh) return;
    const double error = input.mesh->chord_error(), scale = base::millimetres_per(run.report.unit);
    if (error <= tolerance_mm) return;
    run.notice(
        fmt::format("the triangles are up to about {:.2g} {} from the rounded surface they stand "
                    "for, more than the tolerance of {:.2g}: their facets will be followed; "
                    "--tolerance {:.2g}{} is what they can tell",
                    error / scale, base::short_name(run.report.unit), tolerance_mm / scale,
                    2.0 * error / scale, base::short_name(run.report.unit)));
}

}  // namespace patchwright::cli
