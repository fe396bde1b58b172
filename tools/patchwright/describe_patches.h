// Names and colours of the faces that are written.
#pragma once

#include <patchwright/geom/reference_surface.h>
#include <patchwright/patch/patch_set.h>

#include <string>

namespace patchwright::cli {

/// With a source, a patch's name starts with the source's face under its middle. Colours patches by
/// "kind", by "deviation" from the source, or not at all ("none").
/// @pre a source is given for "deviation"
void describe_patches(patch::PatchSet& set, const std::string& colour,
                      const geom::ReferenceSurface* source, double tolerance_mm);

}  // namespace patchwright::cli
