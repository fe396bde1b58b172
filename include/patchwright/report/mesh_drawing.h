// Control meshes and surface grids as pictures show them: polygons and their edges.
#pragma once

#include <patchwright/adapt/local_grid.h>
#include <patchwright/grid/source.h>
#include <patchwright/mesh/cage.h>
#include <patchwright/report/picture.h>

#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::report {

/// What to_png() takes.
struct MeshDrawing {
    measure::Field field;  ///< without curvature and distances
    std::vector<PictureLine> edges;
};

/// Flat polygons, each of the face that its group's number is; edges by their sharpness.
MeshDrawing draw_mesh(const mesh::Cage& cage);

/// Cells on the surface, each of the face that its block's number is; sides of blocks as borders.
MeshDrawing draw_grid(const grid::BlockSource& grid);
/// Borders are those of the surface alone.
MeshDrawing draw_grid(const adapt::LocalGrid& grid);

}  // namespace patchwright::report
#pragma GCC visibility pop
