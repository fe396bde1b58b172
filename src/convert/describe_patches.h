// Names and colours of the faces that are written.
#pragma once

#include <patchwright/convert/shape.h>

namespace patchwright::convert {

/// With a source, a patch's name starts with the source's face under its middle.
/// @throw InvalidArgument when colours by deviation are asked for without a source
void describe_patches(patch::PatchSet& set, Colouring colouring,
                      const geom::ReferenceSurface* source, double tolerance_mm);

}  // namespace patchwright::convert
