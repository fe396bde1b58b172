// The file that a subcommand works on: a CAD model or triangles.
#pragma once

#include "command.h"

#include <patchwright/geom/mesh_reference.h>
#include <patchwright/occ/cad_reference.h>

#include <memory>
#include <optional>

namespace patchwright::cli {

/// A file as read: a CAD model, sewn, or triangles.
struct Input {
    std::optional<occ::CadModel> model;         ///< nothing for triangles
    std::unique_ptr<geom::MeshReference> mesh;  ///< nothing for CAD models
    std::unique_ptr<occ::CadReference> cad;     ///< see prepare
    double sharp_angle_deg = 0.0;               ///< as asked for
    report::SolidFigures figures;
    occ::ReadReport read;  ///< of CAD models
    geom::MeshRepair repair;

    /// @pre prepared
    [[nodiscard]] const geom::ModelSurface& reference() const {
        if (mesh) return *mesh;
        return *cad;
    }
};

struct InputOptions {
    std::string unit;              ///< overrides what the file says; empty: as it says
    bool heal = true;              ///< CAD models: sew and turn faces
    double sharp_angle_deg = 0.0;  ///< 0: as is usual for the kind of file
};

constexpr const char* input_help = "STEP, IGES, BREP, or triangles: STL, OBJ";

void add_input_options(CLI::App& command, InputOptions& options);

/// Reads a CAD file or triangles and fills report.input.
Input read_input(Run& run, const std::string& file, const InputOptions& options = {});

/// How references of the input are made.
occ::ReferenceOptions reference_options(const Run& run, const Input& input);

/// Makes the reference of a CAD model; triangles have theirs.
void prepare(Run& run, Input& input);

/// Says so where the tolerance is less than the triangles' own distance from what they stand for.
void note_chord_error(Run& run, const Input& input, double tolerance_mm);

/// What a model holds, as it is written into reports.
report::SolidFigures solid_figures(const std::string& file, const occ::CadModel& model);

}  // namespace patchwright::cli
