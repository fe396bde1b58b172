// Moves a cage as a whole to where its chains belong, before it is fitted.
#pragma once

#include <patchwright/fit/fit.h>

namespace patchwright::fit {

/// A cage whose chains belong farther away than their own edges are long cannot be fitted step by
/// step: edges would pass each other. Its chains are moved to their targets and the other vertices
/// along with them, as a membrane would be; pinned ones stay. Any other cage is returned as it is.
mesh::Cage placed(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  const FitOptions& options);

}  // namespace patchwright::fit
