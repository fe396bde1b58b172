#include <patchwright/convert/figures.h>
#include <patchwright/geom/mesh_figures.h>
#include <patchwright/occ/inspect_closely.h>

#include <algorithm>

namespace patchwright::convert {

namespace {

report::DetailFigures detail_figures(const Source& input, const occ::CloseInspection& i) {
    report::DetailFigures result{.smallest_face = i.smallest_face,
                                 .smallest_area = i.smallest_area_mm2,
                                 .vertex_tolerance = i.vertex_tolerance_mm,
                                 .edge_tolerance = i.edge_tolerance_mm,
                                 .face_tolerance = i.face_tolerance_mm,
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
    if (i.narrowest) {
        result.narrowest_face = i.narrowest->face;
        result.narrowest_width = i.narrowest->width_mm;
    }
    if (i.shortest_edge) {
        result.shortest_edge = i.shortest_edge->length_mm;
        result.shortest_edge_at = i.shortest_edge->at;
    }
    if (i.open_gaps) {
        result.smallest_open_gap = i.open_gaps->smallest_mm;
        result.largest_open_gap = i.open_gaps->largest_mm;
    }
    return result;
}

report::DetailFigures mesh_details(const Source& input) {
    const geom::MeshFigures m = geom::measure_mesh(input.mesh->mesh(), input.figures.closed);
    const geom::Features& features = input.mesh->features();
    const auto curves = [&](geom::FeatureKind kind) {
        return static_cast<int>(std::count_if(features.curves.begin(), features.curves.end(),
                                              [&](const auto& c) { return c.kind == kind; }));
    };
    const int lines = static_cast<int>(input.mesh->surface_mesh(0.0).features.size());
    const geom::TriangleMesh& mesh = input.mesh->mesh();
    return {.smallest_face = m.smallest,
            .smallest_area = m.smallest_area,
            .narrowest_face = m.narrowest,
            .narrowest_width = m.narrowest_width,
            .shortest_edge = m.shortest_side,
            .shortest_edge_at = m.shortest_at,
            .sharp_edges = lines - m.free_sides,
            .smooth_edges = m.sides - lines,
            .sharp_curves = curves(geom::FeatureKind::Sharp),
            .free_curves = curves(geom::FeatureKind::Free),
            .corners = static_cast<int>(features.corners.size()),
            .centre_of_mass = m.centre,
            .principal_moments = m.moments,
            .moments_of_volume = input.figures.closed,
            .named_faces = static_cast<int>(std::count_if(mesh.part.begin(), mesh.part.end(),
                                                          [](int part) { return part >= 0; })),
            .duplicates_dropped = input.repair.duplicates,
            .slivers_dropped = input.repair.degenerate,
            .faces_turned = input.repair.turned};
}

}  // namespace

measure::Verdict assess(const Source& output, const Source& input,
                        const report::DeviationFigures& deviation, double tolerance_mm,
                        std::optional<double> normal_tolerance_rad) {
    measure::VerdictFigures figures{.tolerance_mm = tolerance_mm,
                                    .diagonal_mm = input.input.diagonal,
                                    .valid = output.figures.valid,
                                    .bodies = output.bodies,
                                    .normal_tolerance_rad = normal_tolerance_rad,
                                    .closed = output.figures.closed};
    if (input.figures.closed) {
        figures.free_edges = output.figures.free_edges;
        figures.bodies_of_input = input.bodies;
    }
    add_deviation(figures, deviation);
    return measure::assess(figures);
}

report::DetailFigures inspect_closely(const Source& source, const base::Progress& progress) {
    if (source.mesh) return mesh_details(source);
    occ::CloseInspectionOptions options{.progress = progress};
    if (source.options.sharp_angle_rad) options.sharp_angle_rad = *source.options.sharp_angle_rad;
    return detail_figures(source, occ::inspect_closely(*source.model, options));
}

void add_fitted(report::RunReport& report, const Attempt& attempt) {
    report.cage = mesh::summarise(*attempt.cage.topology);
    report.layout = attempt.layout;
    report.fit = attempt.fit;
    report.verdict = attempt.verdict;
}

void add_attempt(report::RunReport& report, const Attempt& attempt) {
    add_fitted(report, attempt);
    report.patches = attempt.patches;
    report.solid = attempt.shape.solid;
    report.continuity = attempt.shape.continuity;
    report.deviation = attempt.deviation;
}

}  // namespace patchwright::convert
