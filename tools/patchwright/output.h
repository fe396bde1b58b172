// Turning a cage into a CAD file, and measuring it.
#pragma once

#include "command.h"

#include <patchwright/geom/model_surface.h>
#include <patchwright/occ/cad_model.h>

#include <optional>
#include <string>

namespace patchwright::cli {

/// Options of the subcommands that write a CAD file.
struct OutputOptions {
    std::string file;
    std::string unit = "input";
    std::string schema = "ap214";
    std::string continuity = "g1";
    std::string patches = "charts";
    int cap_depth = 0;  ///< 0: by the tolerance
    std::string colour = "none";
    bool time_stamp = false;
};

void add_output_options(CLI::App& command, OutputOptions& options);

/// A cage's limit surface as a model, with one point on each of its creases.
struct Assembled {
    occ::CadModel model;
    geom::Points crease_points;
};

/// Extracts patches and assembles them; fills report.patches.
/// @param tolerance_mm, source  see write_patches
Assembled assemble_patches(Run& run, const mesh::Cage& cage, const OutputOptions& options,
                           double tolerance_mm, const geom::ReferenceSurface* source = nullptr);

/// Looks at a model; fills report.solid, as of this file, and report.continuity.
void inspect_output(Run& run, const Assembled& output, const std::string& file);

/// Writes, reads back and looks at what was read; the model returned is the one on disk.
occ::CadModel write_assembled(Run& run, const Assembled& assembled, const OutputOptions& options,
                              base::LengthUnit unit);

/// Extracts patches, assembles, writes and reads back; fills report.patches, solid and continuity.
/// The model returned is the one on disk.
/// @param tolerance_mm  how far caps at extraordinary vertices may lie from the limit surface
/// @param source  the CAD that the cage was fitted to, if any: names and colours faces
occ::CadModel write_patches(Run& run, const mesh::Cage& cage, const OutputOptions& options,
                            base::LengthUnit unit, double tolerance_mm,
                            const geom::ReferenceSurface* source = nullptr);

/// Measures both ways and fills report.deviation.
/// @param tolerance_mm  with one, the input's sharp curves longer than 100 times it are looked at
///                      one by one
void compare_models(Run& run, const geom::ModelSurface& output, const geom::ModelSurface& input,
                    int samples, std::optional<double> tolerance_mm = std::nullopt,
                    bool with_bound = true);

/// Adds the bounds that compare_models left out.
void bound_deviation(Run& run, const geom::ModelSurface& output, const geom::ModelSurface& input);

}  // namespace patchwright::cli
