// Files of grids with hanging nodes.
#pragma once

#include <patchwright/adapt/local_grid.h>
#include <patchwright/base/output_set.h>
#include <patchwright/base/units.h>
#include <patchwright/grid/quality.h>

#include <filesystem>

#pragma GCC visibility push(default)
namespace patchwright::adapt {

enum class LocalFormat {
    Cgns,  ///< .cgns: one unstructured zone, a section of elements a family
    Vtk    ///< .vtu: unstructured grid with the quality of cells
};

/// By extension.
/// @throw UsageError for an unknown one
LocalFormat local_format(const std::filesystem::path& file);

/// What a cell beside smaller ones is.
enum class LocalCells {
    Polygons,  ///< hanging nodes are corners of it: cells meet edge to edge
    Quads      ///< four corners: hanging nodes lie in the middle of its sides
};

struct LocalWriteOptions {
    base::LengthUnit unit = base::LengthUnit::Millimetre;  ///< of the numbers in the file
    LocalCells cells = LocalCells::Polygons;
};

/// Measures the quads and writes the grid, and adds the file to `outputs`. Of the figures those of
/// lines through several cells are empty; places name a cell, by i, as the file numbers it.
/// @throw OutputError when it cannot be written
grid::GridQuality write_local_grid(const LocalGrid& grid, const std::filesystem::path& file,
                                   base::OutputSet& outputs, const LocalWriteOptions& options = {});

}  // namespace patchwright::adapt
#pragma GCC visibility pop
