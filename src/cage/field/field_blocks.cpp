#include "cage/field/field_blocks.h"

#include "cage/blocks/brep_layout.h"
#include "cage/blocks/layout_mesh.h"
#include "cage/field/cross_field.h"
#include "cage/field/field_lines.h"
#include "cage/field/field_topology.h"
#include "cage/field/grid_vertices.h"
#include "cage/field/map_grid.h"
#include "cage/field/merge_singularities.h"
#include "cage/field/size_metric.h"
#include "cage/field/whole_blocks.h"

namespace patchwright::cage {

namespace {

// Times that a layout whose quads fold is divided anew, with edges shorter by this factor.
constexpr int most_rounds = 2;
constexpr double finer = 0.7;
// Of the diagonal: singularities and corners that are no farther apart become one.
constexpr double merged_within_rel = 0.02;

/// @throw LayoutRefused
QuadLayout layout_of(const SurfaceBody& body, const std::vector<char>& borders,
                     double tolerance_rel, const geom::ModelSurface& reference, Poll& poll) {
    geom::EditableMesh mesh = layout_mesh(body, borders, tolerance_rel, reference, poll);
    open_corners(mesh);
    const auto hints = curvature_hints(mesh, reference, poll);
    CrossField field = cross_field(mesh, hints, poll);
    FieldTopology topology = field_topology(mesh, field);
    merge_singularities(mesh, field, topology, merged_within_rel * reference.size(), poll);
    const FieldLines lines = field_lines(mesh, field, topology, poll);
    QuadLayout layout = brep_layout(mesh, reference, poll, &lines);
    cut_shared_pieces(layout);
    return layout;
}

/// @throw LayoutRefused
Blocks blocks_of(QuadLayout& layout, MetricSizes sizes, const geom::ModelSurface& reference,
                 const std::vector<std::string>& face_names, Poll& poll) {
    for (int round = 1;; ++round, sizes.scale *= finer) {
        SizeMetric metric(layout, reference, sizes, poll);
        set_wanted(layout, metric, reference, sizes, poll);
        try {
            Divisions divisions = divisions_apart(layout, poll);
            QuadLayout parted = layout;
            part_at_insertions(parted, divisions);
            if (parted.blocks.size() > layout.blocks.size())
                metric = SizeMetric(parted, reference, sizes, poll);
            return map_grid(parted, divisions, metric, reference, face_names, poll);
        } catch (const LayoutRefused& refusal) {
            if (refusal.for_good || round == most_rounds) throw;
        }
    }
}

}  // namespace

BodyBlocks field_blocks(const SurfaceBody& body, const std::vector<char>& borders,
                        const geom::ModelSurface& reference,
                        const std::vector<std::string>& face_names, const CageOptions& options,
                        Poll& poll, double scale) {
    try {
        QuadLayout layout = layout_of(body, borders, options.tolerance_rel, reference, poll);
        const MetricSizes sizes{
            .tolerance_rel = options.tolerance_rel, .fineness = options.fineness, .scale = scale};
        return {blocks_of(layout, sizes, reference, face_names, poll), {}};
    } catch (const LayoutRefused& refusal) {
        return {std::nullopt, refusal.why};
    }
}

}  // namespace patchwright::cage
