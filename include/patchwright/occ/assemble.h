// From B-spline patches to a B-rep with shared topology.
#pragma once

#include <patchwright/occ/cad_model.h>
#include <patchwright/patch/patch_set.h>

#include <string>

#pragma GCC visibility push(default)
namespace patchwright::occ {

/// The CAD kernel tells points apart that are 1e-7 mm from each other, whatever the model's size:
/// coordinates must be known to that, and the model must be large beside it.
inline constexpr double largest_coordinate_mm = 1e7, least_diagonal_mm = 1e-2;

/// @throw InputError with `source` before the message when these limits are exceeded
void check_size(const geom::Box3& box, const std::string& source);

/// Builds vertices, edges and faces directly, shared as in the patch set, with straight p-curves on
/// the surfaces' natural boundaries; nothing is sewn. Each connected closed component becomes a
/// solid of positive volume, or a void of the solid that it lies in; each open one a shell. Smooth
/// edges are marked as such, names and colours of faces are kept for formats that have them.
/// @throw InvalidArgument when an edge is used more than twice, or twice in the same direction
CadModel assemble(const patch::PatchSet& patches);

}  // namespace patchwright::occ
#pragma GCC visibility pop
