// The limit surface of a cage as a CAD file among a run's outputs.
#pragma once

#include "command.h"

#include <patchwright/convert/shape.h>

#include <string>

namespace patchwright::cli {

/// Adds the file to the run's outputs, and to its report what the file, read back, is: patches,
/// solid, continuity, verdict.
/// @param tolerance_mm    of the patches from the limit surface
/// @param bad_grid_cells  of a grid of the same surface, for the verdict on both
/// @return  the model as read back
occ::CadModel write_surface(Run& run, const mesh::Cage& cage, const std::string& file,
                            const convert::ShapeOptions& making, double tolerance_mm,
                            const std::optional<measure::Failures>& bad_grid_cells = std::nullopt);

}  // namespace patchwright::cli
