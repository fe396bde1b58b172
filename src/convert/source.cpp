#include <patchwright/base/error.h>
#include <patchwright/convert/source.h>
#include <patchwright/geom/mesh_figures.h>
#include <patchwright/mesh/read_triangles.h>
#include <patchwright/occ/inspect.h>
#include <patchwright/occ/narrow_holes.h>

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace patchwright::convert {

namespace {

/// Blades and wings are not that small or large, but files whose unit is wrong are.
constexpr double small_mm = 300.0, large_mm = 300e3;

/// Of the diagonal: coordinates that are rounded to more turn normals and sew wrong sides together.
constexpr double most_rounding_rel = 1e-9;

/// @throw InputError when the model is so far from the origin that rounding shows
void check_rounding(const geom::Box3& box, const std::string& file) {
    const double farthest = std::max(-box.min.minCoeff(), box.max.maxCoeff());
    const double rounding = std::numeric_limits<double>::epsilon() * farthest;
    if (rounding <= most_rounding_rel * box.diagonal()) return;
    throw base::InputError(fmt::format(
        "{}: coordinates up to {:.3g} mm are rounded to {:.2g} mm, more than {:g} of the model's "
        "diagonal of {:.3g} mm; move it nearer to the origin",
        file, farthest, rounding, most_rounding_rel, box.diagonal()));
}

Source read_model(const std::string& file, const SourceOptions& options) {
    const occ::ReadOptions reading{.unit = options.unit,
                                   .allow_loss = options.allow_loss,
                                   .heal = options.heal,
                                   .progress = options.progress};
    occ::ReadResult result =
        options.reader != nullptr
            ? occ::read_cad_guarded(file, *options.reader, reading, options.limits)
            : occ::read_cad(file, reading);
    const occ::ReadReport& read = result.report;
    Source source{.model = result.model,
                  .figures = solid_figures(file, result.model),
                  .bodies = static_cast<int>(occ::connected_faces(result.model).size()),
                  .read = read,
                  .options = options,
                  .notices = read.notices};
    check_rounding(source.figures.bounds, file);
    const double diagonal = source.figures.bounds.diagonal();
    if (!options.unit && (diagonal < small_mm || diagonal > large_mm)) {
        source.notices.push_back(
            fmt::format("{}: the model is {:.3g} m across by its unit, {}; if that is wrong, "
                        "see --input-unit",
                        file, 1e-3 * diagonal, base::short_name(read.unit)));
    }
    constexpr const char* formats[] = {"STEP", "IGES", "BREP"};
    source.input = {.file = file,
                    .format = formats[static_cast<int>(read.format)],
                    .schema = read.schema,
                    .originating_system = read.originating_system,
                    .unit = read.unit,
                    .solids = source.figures.solids,
                    .faces = source.figures.faces,
                    .free_edges = source.figures.free_edges,
                    .diagonal = diagonal};
    if (read.sewn) {
        source.input.largest_gap_closed = read.sewn->largest_mm;
        source.input.sewing_tolerance = read.sewn->tolerance_mm;
    }
    if (!options.with_surface) return source;
    source.cad = std::make_shared<const occ::CadReference>(
        *source.model, source.reference_options(options.progress));
    return source;
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

Source read_mesh(const std::string& file, const SourceOptions& options) {
    if (options.foot_points == occ::FootPoints::Kernel)
        throw base::InputError(
            file +
            ": the CAD kernel has no foot points of triangles; leave them to the "
            "search");
    const base::LengthUnit unit = options.unit.value_or(base::LengthUnit::Millimetre);
    mesh::TriangleFile result = mesh::read_triangles(file, base::millimetres_per(unit));
    geom::MeshReferenceOptions reference;
    if (options.sharp_angle_rad) reference.sharp_angle_rad = *options.sharp_angle_rad;
    Source source{
        .mesh = std::make_shared<const geom::MeshReference>(std::move(result.mesh), reference),
        .bodies = result.repair.bodies,
        .repair = result.repair,
        .is_control_mesh = result.is_control_mesh,
        .options = options,
        .notices = result.notices};
    source.figures = mesh_figures(file, *source.mesh, result.repair);
    check_rounding(source.mesh->bounds(), file);
    const double diagonal = source.mesh->bounds().diagonal();
    if (!options.unit)
        source.notices.push_back(fmt::format(
            "{}: files of this kind hold no unit; read as mm it is {:.3g} m across; see "
            "--input-unit",
            file, 1e-3 * diagonal));
    source.input = {.file = file,
                    .format = result.format,
                    .unit = unit,
                    .solids = source.figures.solids,
                    .faces = source.figures.faces,
                    .free_edges = source.figures.free_edges,
                    .diagonal = diagonal};
    return source;
}

}  // namespace

std::vector<std::string> leave_out_narrow_holes(Source& source, double width_mm) {
    if (!source.model) return {};
    const auto [model, holes] = occ::without_narrow_holes(*source.model, width_mm);
    if (holes.empty()) return {};
    source.model = model;
    source.figures = solid_figures(source.input.file, model);
    source.cad = std::make_shared<const occ::CadReference>(
        model, source.reference_options(source.options.progress));
    source.input.holes_left_out = int(holes.size());
    const auto widest =
        std::max_element(holes.begin(), holes.end(),
                         [](const auto& a, const auto& b) { return a.width_mm < b.width_mm; });
    const double unit = base::millimetres_per(source.input.unit);
    const geom::Vec3 at = widest->at / unit;
    const auto name = base::short_name(source.input.unit);
    return {
        fmt::format("{} narrower than the tolerance of {:.3g} {} left out; the widest, {:.3g} "
                    "{}, is at ({:.4g}, {:.4g}, {:.4g})",
                    holes.size() == 1 ? "1 hole" : fmt::format("{} holes", holes.size()),
                    width_mm / unit, fmt::format("{} {}", name, holes.size() == 1 ? "is" : "are"),
                    widest->width_mm / unit, name, at.x(), at.y(), at.z())};
}

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

const geom::ModelSurface& Source::surface() const {
    if (mesh) return *mesh;
    return *cad;
}

occ::ReferenceOptions Source::reference_options(base::Progress progress) const {
    occ::ReferenceOptions reference{.progress = std::move(progress)};
    reference.foot_points = options.foot_points;
    if (options.sharp_angle_rad) reference.sharp_angle_rad = *options.sharp_angle_rad;
    return reference;
}

Source read_source(const std::filesystem::path& file, const SourceOptions& options) {
    return mesh::is_triangle_file(file) ? read_mesh(file.string(), options)
                                        : read_model(file.string(), options);
}

}  // namespace patchwright::convert
