// The limit surface of a cage as a CAD file among a run's outputs.
#pragma once

#include "command.h"

#include <patchwright/convert/shape.h>

#include <optional>
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

/// What write_moved_surface() is told beside the cage.
struct MovedSurface {
    std::string file;
    std::string tolerance;  ///< of add_surface_tolerance()
    std::string cause;      ///< file that moved the cage
    std::optional<measure::Failures> bad_grid_cells = std::nullopt;
};

/// Adds the option --tolerance of what --cad-out writes.
void add_surface_tolerance(CLI::App& command, std::string& tolerance);

/// write_surface() in the report's unit, of a cage that was moved.
/// @throw InputError naming the cause where the surface is too large for CAD
void write_moved_surface(Run& run, const mesh::Cage& cage, const MovedSurface& surface);

}  // namespace patchwright::cli
