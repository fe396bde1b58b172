// The limit surface of a cage as a CAD file among a run's outputs.
#pragma once

#include "command.h"

#include <patchwright/convert/shape.h>

#include <string>

namespace patchwright::cli {

/// Adds the file to the run's outputs, and to its report what the file, read back, is: patches,
/// solid, continuity, verdict.
/// @param tolerance_mm  of the patches from the limit surface
/// @return  the model as read back
occ::CadModel write_surface(Run& run, const mesh::Cage& cage, const std::string& file,
                            const convert::ShapeOptions& making, double tolerance_mm);

}  // namespace patchwright::cli
