// Singularities of a cross field that lie beside one another or beside a corner become one.
#pragma once

#include "cage/field/cross_field.h"
#include "cage/field/field_topology.h"

namespace patchwright::cage {

/// Merges singularities with corners of features, where the sector still has room for its quads,
/// and with each other, the nearest first. A field that is smooth for its size alone leaves them
/// apart by much less than an edge, and what lies between becomes slivers. The field turns by a
/// harmonic angle that jumps by the singularity's index along a path between both.
/// Source: Crane, Desbrun and Schroeder, Trivial connections on discrete surfaces (2010).
/// @param topology  of the field; of the new one afterwards
/// @param reach_mm  longest path between what is merged
void merge_singularities(const geom::EditableMesh& mesh, CrossField& field, FieldTopology& topology,
                         double reach_mm, Poll& poll);

}  // namespace patchwright::cage
