#include "cage/field/field_blocks.h"

#include "cage/blocks/block_grid.h"
#include "cage/blocks/brep_layout.h"
#include "cage/blocks/divisions.h"
#include "cage/blocks/layout_mesh.h"
#include "cage/field/cross_field.h"
#include "cage/field/division_search.h"
#include "cage/field/field_lines.h"
#include "cage/field/field_topology.h"
#include "cage/field/size_metric.h"

namespace patchwright::cage {

namespace {

// Times that a layout whose quads fold is divided anew, with edges shorter by this factor.
constexpr int most_rounds = 2;
constexpr double finer = 0.7;

/// @throw LayoutRefused
QuadLayout layout_of(const SurfaceBody& body, const std::vector<char>& borders,
                     double tolerance_rel, const geom::ModelSurface& reference, Poll& poll) {
    geom::EditableMesh mesh = layout_mesh(body, borders, tolerance_rel, reference, poll);
    open_corners(mesh);
    const auto hints = curvature_hints(mesh, reference, poll);
    CrossField field = cross_field(mesh, hints, poll);
    const FieldTopology topology = field_topology(mesh, field);
    const FieldLines lines = field_lines(mesh, field, topology, poll);
    return brep_layout(mesh, reference, poll, &lines);
}

/// @throw LayoutRefused
Blocks blocks_of(QuadLayout& layout, MetricSizes sizes, const geom::ModelSurface& reference,
                 const std::vector<std::string>& face_names, Poll& poll) {
    for (int round = 1;; ++round, sizes.scale *= finer) {
        const SizeMetric metric(layout, reference, sizes, poll);
        set_wanted(layout, metric, reference, sizes, poll);
        try {
            const Divisions divisions =
                improved_divisions(layout, divide_arcs(layout, poll, Deviation::Logarithmic), poll);
            return block_grid(layout, divisions, reference, face_names, poll, &metric);
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
