#include "cage/field/body_blocks.h"

#include "cage/blocks/brep_layout.h"
#include "cage/blocks/folded_quads.h"
#include "cage/blocks/layout_mesh.h"
#include "cage/blocks/layout_refused.h"
#include "cage/blocks/wide_corners.h"
#include "cage/field/cross_field.h"
#include "cage/field/field_lines.h"
#include "cage/field/field_topology.h"
#include "cage/field/grid_vertices.h"
#include "cage/field/map_grid.h"
#include "cage/field/merge_singularities.h"
#include "cage/field/size_metric.h"
#include "cage/field/whole_blocks.h"
#include "cage/symmetry/mirror_blocks.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// A layout whose quads fold is divided anew, with edges shorter by this factor; one along faces as
// long as the model sticks out of quads by so much of the root of their area, in at most so many
// rounds and quads.
constexpr double finer = 0.7, most_sag = 0.3;
constexpr int most_rounds_for_folds = 2, most_rounds_for_sag = 5;
constexpr std::size_t many_quads = 1000;
// Of the diagonal: singularities and corners that are no farther apart become one.
constexpr double merged_within_rel = 0.02;
// Of the tolerance: how far the limit surface may go beyond corners of two quads before it is
// fitted.
constexpr double most_beyond_corners = 0.1;

/// How far points between the corners of quads are from the model, of the roots of their areas.
double worst_sag(const Blocks& blocks, const geom::ModelSurface& reference, Poll& poll) {
    double worst = 0.0;
    for (std::size_t f = 0; f < blocks.faces.size(); ++f) {
        poll();
        std::array<Vec3, 4> p;
        for (std::size_t k = 0; k < 4; ++k) p[k] = blocks.points[at(blocks.faces[f][k])];
        const Vec3 area = quad_area(blocks, f);
        for (const auto& [u, v] :
             {std::pair{0.5, 0.5}, {0.25, 0.25}, {0.75, 0.25}, {0.75, 0.75}, {0.25, 0.75}}) {
            const Vec3 q =
                (1 - u) * (1 - v) * p[0] + u * (1 - v) * p[1] + u * v * p[2] + (1 - u) * v * p[3];
            worst = std::max(worst, reference.foot_point(q, area.normalized()).distance /
                                        std::sqrt(area.norm()));
        }
    }
    return worst;
}

/// The whole that a half is of.
const geom::ModelSurface& whole_of(const BlockSource& source) {
    return source.half != nullptr ? source.half->whole() : source.reference;
}

/// As a share of the reference's size: a half is smaller than the whole.
double tolerance_of(const BlockSource& source, const CageOptions& options) {
    return options.tolerance_rel * whole_of(source).size() / source.reference.size();
}

/// @throw LayoutRefused
QuadLayout field_layout(const BlockSource& source, const std::vector<char>& borders,
                        double tolerance_rel, Poll& poll, int& closed_strips) {
    const geom::ModelSurface& reference = source.reference;
    geom::EditableMesh mesh =
        layout_mesh(source.body, borders, tolerance_rel, reference, poll, closed_strips);
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
QuadLayout face_layout(const BlockSource& source, const std::vector<char>& borders,
                       double tolerance_rel, Poll& poll, int& closed_strips) {
    geom::EditableMesh mesh =
        layout_mesh(source.body, borders, tolerance_rel, source.reference, poll, closed_strips);
    QuadLayout layout = brep_layout(mesh, source.reference, poll);
    cut_shared_pieces(layout);
    return layout;
}

/// @throw LayoutRefused
Blocks blocks_of(QuadLayout& layout, MetricSizes sizes, const BlockSource& source, Poll& poll) {
    const double tolerance_mm = sizes.tolerance_rel * source.reference.size();
    for (int round = 1;; ++round, sizes.scale *= finer) {
        SizeMetric metric(layout, source.reference, sizes, poll);
        set_wanted(layout, metric, source.reference, sizes, poll);
        try {
            Divisions divisions = divisions_apart(layout, poll);
            QuadLayout parted = layout;
            part_at_insertions(parted, divisions);
            if (parted.blocks.size() > layout.blocks.size())
                metric = SizeMetric(parted, source.reference, sizes, poll);
            BlocksOnCurves made = map_grid(parted, divisions, metric, source.reference, poll);
            if (source.half != nullptr)
                made = with_mirror_image(std::move(made), *source.half, closed_share * tolerance_mm,
                                         poll);
            divide_at_wide_corners(made.blocks, std::move(made.curves), whole_of(source),
                                   most_beyond_corners * tolerance_mm, poll);
            return checked(std::move(made.blocks), whole_of(source), source.face_names, poll);
        } catch (const LayoutRefused& refusal) {
            if (refusal.for_good || round == most_rounds_for_folds) throw;
        }
    }
}

MetricSizes sizes_of(const BlockSource& source, const CageOptions& options, double scale) {
    return {.tolerance_rel = tolerance_of(source, options),
            .fineness = options.fineness,
            .scale = scale};
}

}  // namespace

BodyBlocks field_blocks(const BlockSource& source, const std::vector<char>& borders,
                        const CageOptions& options, Poll& poll, double scale) {
    BodyBlocks result;
    try {
        QuadLayout layout = field_layout(source, borders, tolerance_of(source, options), poll,
                                         result.closed_strips);
        result.blocks = blocks_of(layout, sizes_of(source, options, scale), source, poll);
    } catch (const LayoutRefused& refusal) {
        result.refused = refusal.why;
    }
    return result;
}

BodyBlocks face_blocks(const BlockSource& source, const std::vector<char>& borders,
                       const CageOptions& options, Poll& poll, double scale) {
    BodyBlocks result;
    try {
        QuadLayout layout =
            face_layout(source, borders, tolerance_of(source, options), poll, result.closed_strips);
        MetricSizes sizes = sizes_of(source, options, scale);
        result.blocks = blocks_of(layout, sizes, source, poll);
        // What sticks out of the middle of a large block is seen by no line along it.
        for (int round = 1; round < most_rounds_for_sag &&
                            worst_sag(*result.blocks, whole_of(source), poll) >= most_sag;
             ++round) {
            sizes.scale *= finer;
            Blocks next = blocks_of(layout, sizes, source, poll);
            if (next.faces.size() > many_quads) break;
            result.blocks = std::move(next);
        }
    } catch (const LayoutRefused& refusal) {
        if (!result.blocks) result.refused = refusal.why;
    }
    return result;
}

}  // namespace patchwright::cage
