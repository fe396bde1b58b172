// Places on a model's faces, evenly by area, and lines of constant parameter through some of them.
#pragma once

#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::measure {

struct SurfacePlace {
    int face;
    Eigen::Vector2d uv;
};

/// Each stands for the same area; deterministic. Fewer where the model has no area.
std::vector<SurfacePlace> places_by_area(const geom::ModelSurface& model, int count);

struct ParameterLine {
    int face;
    Eigen::Vector2d start, end;  ///< parameters
    int steps;                   ///< equal ones in parameters
};

/// From side to side of faces that fill the rectangle of their parameters, half of them along each
/// parameter, evenly by area. Fewer where trimmed faces would have some.
/// @param step_mm  length of a step, about
std::vector<ParameterLine> parameter_lines(const geom::ModelSurface& model, int count,
                                           double step_mm);

/// steps + 1 of them.
std::vector<geom::FootPoint> points_on(const geom::ModelSurface& model, const ParameterLine& line);

}  // namespace patchwright::measure
