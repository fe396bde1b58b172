// What the formats of grids with hanging nodes have in common.
#pragma once

#include "grid/writer.h"

#include <patchwright/adapt/write.h>

namespace patchwright::adapt {

/// A grid as it is written.
struct LocalFile {
    const LocalGrid& grid;
    std::array<std::vector<double>, 3> coordinates;  ///< in the file's unit
    /// Numbers of cells in their order in the file: family by family.
    std::vector<std::int32_t> order;
    grid::CellFields fields;  ///< in that order
    LocalWriteOptions options;

    /// Corners of a cell, and hanging nodes where they are corners too.
    void add_corners(std::int32_t cell, std::vector<std::int32_t>& corners) const;
};

void write_local_cgns(const LocalFile& content, base::PendingFile& file);
void write_local_vtk(const LocalFile& content, base::PendingFile& file);

}  // namespace patchwright::adapt
