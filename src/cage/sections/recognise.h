// Bodies that get blocks along the lines of what they are.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"
#include "cage/sections/sections.h"

#include <patchwright/geom/model_surface.h>

#include <optional>
#include <string>

namespace patchwright::cage {

struct Recognised {
    std::optional<Blocks> blocks;
    std::string text;  ///< what the body is, or why it is nothing known
};

struct RecogniseOptions {
    /// > 0: rings along the body are about that many times as many, lines around it by its root.
    double fineness = 1.0;
    double tolerance_mm = 0.0;  ///< what the cage is to be fitted to
};

Recognised recognise(const SurfaceBody& body, const geom::ModelSurface& reference,
                     const RecogniseOptions& options, Poll& poll);

}  // namespace patchwright::cage
