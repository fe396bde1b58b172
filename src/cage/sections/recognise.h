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

/// @param fineness  > 0: rings along the body are about that many times as many, lines around it by
///                  its root
Recognised recognise(const SurfaceBody& body, const geom::ModelSurface& reference, double fineness,
                     Poll& poll);

}  // namespace patchwright::cage
