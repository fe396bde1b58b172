// The model that is converted: a CAD file or triangles, as read.
#pragma once

#include <patchwright/geom/mesh_reference.h>
#include <patchwright/occ/cad_reference.h>
#include <patchwright/occ/guarded_read.h>
#include <patchwright/report/run_report.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::convert {

struct SourceOptions {
    std::optional<base::LengthUnit> unit;   ///< overrides what the file says; triangles: else mm
    bool allow_loss = false;                ///< CAD: faces that cannot be transferred are a notice
    bool heal = true;                       ///< CAD: sew loose faces, turn faces outward
    std::optional<double> sharp_angle_rad;  ///< none: 20 degrees, for triangles 35
    bool with_surface = true;               ///< make the reference surface of a CAD model
    /// CAD: of its reference surface, its bodies and what is made of it; triangles have their own.
    occ::FootPoints foot_points = occ::FootPoints::Search;
    occ::ReaderProcess* reader = nullptr;  ///< CAD: reads in its place; null: this process reads
    occ::ReadLimits limits;                ///< of `reader`
    base::Progress progress;
};

/// What a file holds. Lengths are millimetres whatever the file's unit.
struct Source {
    std::optional<occ::CadModel> model;               ///< none for triangles
    std::shared_ptr<const geom::MeshReference> mesh;  ///< none for CAD models
    std::shared_ptr<const occ::CadReference> cad;     ///< of `model`, if asked for
    report::InputFigures input;
    report::SolidFigures figures;
    int bodies = 0;                ///< faces that hang together
    occ::ReadReport read;          ///< of CAD models
    geom::MeshRepair repair;       ///< of triangles
    bool is_control_mesh = false;  ///< polygons with tags of subdivision
    bool is_body = false;          ///< one of a model's: it may be a film
    SourceOptions options;
    std::vector<std::string> notices;  ///< one line each, for the user

    /// @pre made with a surface
    [[nodiscard]] const geom::ModelSurface& surface() const;
    /// For reference surfaces of `model` or its bodies.
    [[nodiscard]] occ::ReferenceOptions reference_options(base::Progress progress) const;
};

/// Reads STEP, IGES, BREP, STL or triangles in OBJ.
/// @throw InputError when the file cannot be read or holds no faces, or holds triangles where the
///        kernel's foot points are asked for
/// @throw Cancelled or TimeLimitReached from the progress callback
Source read_source(const std::filesystem::path& file, const SourceOptions& options = {});

/// Closes holes of a CAD model that are narrower than what matters (occ::without_narrow_holes()).
/// @pre made with a surface
/// @return what was left out, one line each, for the user
std::vector<std::string> leave_out_narrow_holes(Source& source, double width_mm);

/// What a model holds, as reports tell it.
report::SolidFigures solid_figures(const std::string& file, const occ::CadModel& model);

}  // namespace patchwright::convert
#pragma GCC visibility pop
