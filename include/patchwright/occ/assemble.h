// From B-spline patches to a B-rep with shared topology.
#pragma once

#include <patchwright/occ/cad_model.h>
#include <patchwright/patch/patch_set.h>

namespace patchwright::occ {

/// Builds vertices, edges and faces directly, shared as in the patch set, with straight p-curves on
/// the surfaces' natural boundaries; nothing is sewn. Each connected closed component becomes a
/// solid of positive volume, or a void of the solid that it lies in; each open one a shell. Smooth
/// edges are marked as such, names and colours of faces are kept for formats that have them.
/// @throw InvalidArgument when an edge is used more than twice, or twice in the same direction
CadModel assemble(const patch::PatchSet& patches);

}  // namespace patchwright::occ
