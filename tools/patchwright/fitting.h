// Making cages and fitting them to the input.
#pragma once

#include "input.h"

#include <patchwright/cage/bodies.h>
#include <patchwright/cage/make_cage.h>
#include <patchwright/fit/fit_parts.h>

#include <optional>
#include <string>
#include <vector>

namespace patchwright::cli {

/// How a cage is made where none is given.
struct LayoutOptions {
    std::string method = "auto";
    int target_faces = 0;   ///< 0: as curvature asks for
    double fineness = 1.0;  ///< of a further try, as those below: see cage::CageOptions
    std::vector<cage::CageOptions::Place> finer_at;
};

void add_layout_options(CLI::App& command, LayoutOptions& options);

/// Makes a cage from the input; fills report.cage.
/// @pre the input is prepared
cage::CageResult make_cage(Run& run, const Input& input, const LayoutOptions& options,
                           double tolerance_rel);

/// Of the tolerance, for caps at extraordinary vertices and for what lies between the fit's
/// samples; the rest is for the fit.
inline constexpr double caps_share = 0.05;

/// Options of the subcommands that fit.
struct FitCommandOptions {
    std::string tolerance = "1e-4rel";
    std::string cage_unit = "mm";
    std::string refine = "local";
    std::string symmetry = "detect";
    int max_levels = 12;
    int max_vertices = 200000;             ///< of a fitted cage
    int max_idle_levels = 12;              ///< see fit::FitOptions
    bool preserve_parametrisation = true;  ///< see fit::FitOptions
};

/// For a cage that was made: its form is no model for the fitted one's, and one that is no wing's
/// is made anew where it is too coarse, instead of being refined again and again.
FitCommandOptions for_made_cage(FitCommandOptions options, const cage::CageResult& made);

void add_fit_options(CLI::App& command, FitCommandOptions& options);

/// What parts of made cages are fitted to, and what came of it so far.
struct PartFits {
    std::vector<geom::BodyReference> bodies;
    std::vector<fit::PartFit> known;
};

/// Nothing for triangles and for models that hang together.
/// @pre the input is prepared
std::optional<PartFits> part_fits(Run& run, const Input& input);

/// Fits and fills report.fit; the tolerance is for the final, two-sided deviation.
/// @param parts  with it, parts of the cage that do not hang together are fitted each to the body
///               of the model that it lies on, and results are kept for parts that come again
mesh::Cage fit_cage(Run& run, const mesh::Cage& cage, const geom::ModelSurface& reference,
                    const FitCommandOptions& options, PartFits* parts = nullptr);

/// The tolerance as a fraction of the reference's diagonal.
double relative_tolerance(const FitCommandOptions& options,
                          const geom::ReferenceSurface& reference);

}  // namespace patchwright::cli
