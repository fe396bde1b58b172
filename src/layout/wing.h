// Wing-like bodies: thin closed sections one after another along a span.
#pragma once

#include "layout/blocks.h"
#include "layout/sections.h"

#include <patchwright/geom/model_surface.h>

#include <optional>

namespace patchwright::layout {

struct WingOptions {
    int columns = 8;  ///< points from the trailing edge to the nose, each side, both ends included
    int spans = 5;    ///< intervals along the whole span, about
};

/// A box of quads around the body: rings of points at stations along the span, each from the
/// trailing edge around the nose, and lids of quads between the lower and the upper side where the
/// body is closed. Nothing when the body is not a wing.
std::optional<Blocks> wing_blocks(const Body& body, const geom::ModelSurface& reference,
                                  const WingOptions& options = {});

}  // namespace patchwright::layout
