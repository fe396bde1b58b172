// Cuts along edges of a piece that are rounded tightly.
#pragma once

#include "cage/blocks/cuts.h"
#include "cage/blocks/piece_mesh.h"
#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

#include <optional>

namespace patchwright::cage {

/// The line of a nose that runs through a piece from border to border, as on the skin of a wing in
/// one piece: where the surface is bent too tightly for faces of a cage, but across only, and only
/// in a narrow strip. Nothing when there is no such strip.
std::optional<Cut> crest_cut(const CutPiece& piece, const PieceMesh& mesh,
                             const geom::ModelSurface& reference, Poll& poll);

}  // namespace patchwright::cage
