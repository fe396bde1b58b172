// What is measured for looking at: fields as files, and the scene of the HTML report.
#pragma once

#include "command.h"

#include <patchwright/geom/model_surface.h>

#include <optional>
#include <string>

namespace patchwright::cli {

struct View {
    const geom::ModelSurface* output = nullptr;
    const geom::ModelSurface* input = nullptr;  ///< may be null
    const mesh::Cage* cage = nullptr;           ///< may be null
    /// Deviation that is the last colour; none: the largest one.
    std::optional<double> scale_mm;
    std::string field;  ///< file of the output's field; empty: none
};

constexpr const char* field_help =
    "write deviation, normal angle and curvature all over the output: .vtp (ParaView) or .glb";

/// Adds the field's file to the run's outputs, and the scene to its report where HTML is asked for.
void add_views(Run& run, const View& view);

}  // namespace patchwright::cli
