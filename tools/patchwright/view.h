// What is measured for looking at: fields and pictures as files, the scene of the HTML report.
#pragma once

#include "command.h"

#include <patchwright/geom/model_surface.h>
#include <patchwright/report/mesh_drawing.h>

#include <optional>
#include <string>

namespace patchwright::cli {

/// Options of subcommands that show a model.
struct ViewArguments {
    std::string field, picture;  ///< files; empty: none
    std::string from = "iso", size = "960x540";
    std::string direction;  ///< "X,Y,Z" in place of `from`; or empty
    std::string zoom;       ///< "X,Y,Z,WIDTH"; empty: all is seen
    report::PictureLayer layer = report::PictureLayer::Deviation;
};

/// @param with_field  --field too, for subcommands that compare with another model
void add_view_options(CLI::App& command, ViewArguments& options, bool with_field);

/// Those of the picture alone, for subcommands that draw a mesh in the colours of its groups.
void add_picture_options(CLI::App& command, ViewArguments& options);

/// The files that these options write.
std::vector<OutputFile> view_files(const ViewArguments& options);

struct View {
    const geom::ModelSurface* output = nullptr;
    const geom::ModelSurface* input = nullptr;  ///< may be null
    const mesh::Cage* cage = nullptr;           ///< may be null
    /// Deviation that is the last colour; none: the largest one.
    std::optional<double> scale_mm;
};

/// Whether anything is to be shown: if not, surfaces are not needed.
bool shows_anything(const Run& run, const ViewArguments& options);

/// Adds the field's and the picture's files to the run's outputs, and the scene to its report where
/// HTML is asked for.
void add_views(Run& run, const ViewArguments& options, const View& view);

/// Adds the picture's file to the run's outputs where it is asked for, and the picture to its HTML.
void add_drawing(Run& run, const ViewArguments& options, const report::MeshDrawing& drawing,
                 const std::string& caption);

}  // namespace patchwright::cli
