// Split cages brought back to the limit surface that they come from.
#pragma once

#include <patchwright/fit/fit.h>
#include <patchwright/mesh/cage.h>

namespace patchwright::fit {

/// Moves control points until the limit surface is near that of `former`, and its sharp curves are
/// near those of `former`: single strips that are split, and graded spacing, move it, and farther
/// than the level before ended from the reference where faces are large for what they bend around.
/// Steps as those to the reference (decisions 016, 017), but for faces and sharp curves in one
/// problem, and all of them are taken. Pinned vertices stay.
/// @param cage     near `former`, its faces in other places and of other sizes
/// @param options  tolerance, solver and progress of the fit
/// @throw what options.progress throws
void return_to(mesh::Cage& cage, const mesh::Cage& former, const FitOptions& options);

}  // namespace patchwright::fit
