// The lines of a layout of quads: along a cross field from its singularities and corners.
#pragma once

#include "cage/field/field_topology.h"
#include "cage/poll.h"

#include <vector>

namespace patchwright::cage {

struct FieldLines {
    /// Each along sides of the mesh, from a singularity or a corner to another one or into a line
    /// or border.
    std::vector<std::vector<int>> lines;
    /// At every vertex of a border, and of lines where these end or cross: between two sides of
    /// lines or borders, with at least one quad.
    std::vector<FieldSector> sectors;
};

/// Connects singularities and corners first, the shortest and straightest ones first, by lines that
/// deviate from the field by little; what is left goes on until it meets a line or a border.
/// Source: Campen, Bommes and Kobbelt, Quantized global parametrization (2015); Pietroni et al.,
/// Reliable feature-line driven quad-remeshing (2021); both connect nodes first.
/// @param mesh, field  changed: lines become sides of triangles, in their planes
/// @throw LayoutRefused when a line cannot be drawn
FieldLines field_lines(geom::EditableMesh& mesh, CrossField& field, const FieldTopology& topology,
                       Poll& poll);

}  // namespace patchwright::cage
