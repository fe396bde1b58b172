// How a surface differs from another one, and how it bends, all over it: for pictures and for other
// programs.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/model_surface.h>

#include <array>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::measure {

/// Triangles of a model with values at their vertices. Where faces meet, each has vertices of its
/// own.
struct Field {
    geom::Points points;                        ///< on the model, mm
    geom::Points normals;                       ///< unit, outward; zero where the surface has none
    std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
    /// One a triangle: the model's face; 0 for models without CAD faces.
    std::vector<int> faces;
    /// Mean of the principal curvatures, 1/mm, see geom::Curvature; 0 where the surface is
    /// degenerate.
    std::vector<double> curvature;
    /// At the other model's nearest points; empty where there is no other one.
    std::vector<double> distance_mm;
    std::vector<double> normal_angle_rad;  ///< between tangent planes; 0 where one has none
    std::vector<double> other_curvature;
    std::vector<geom::Points> lines;  ///< sharp and free curves
};

struct FieldOptions {
    /// Of triangles' sides, fraction of the diagonal.
    double longest_side_rel = 1.0 / 64;
    /// Sides along which the distance changes by more than this, fraction of the largest one, are
    /// halved until they are an eighth of that length.
    double largest_step_rel = 1.0 / 16;
    /// Nothing is refined any more from this number of vertices on.
    int most_vertices = 400000;
    base::Progress progress;
};

/// From the triangles that the model is searched by (see geom::ModelSurface::pieces), refined.
/// @param other  may be null
/// @throw Cancelled or TimeLimitReached from the progress callback
Field measure_field(const geom::ModelSurface& model, const geom::ModelSurface* other,
                    const FieldOptions& options = {});

}  // namespace patchwright::measure
#pragma GCC visibility pop
