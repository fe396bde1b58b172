// Grid files, written block by block: only one block is in memory at a time.
#pragma once

#include <patchwright/base/output_set.h>
#include <patchwright/base/progress.h>
#include <patchwright/base/units.h>
#include <patchwright/grid/quality.h>

#include <filesystem>

#pragma GCC visibility push(default)
namespace patchwright::grid {

enum class GridFormat {
    Cgns,    ///< .cgns: HDF5; zones, one-to-one connections, families, units
    Plot3d,  ///< .xyz, .p3d: multi-block whole grid, double precision, without blanking
    Vtk      ///< .vtm, with a folder of the same name that holds a .vts file a block; cell quality
};

/// By extension.
/// @throw UsageError for an unknown one
GridFormat grid_format(const std::filesystem::path& file);

struct Plot3dOptions {
    enum class Form {
        Binary,   ///< numbers only
        Fortran,  ///< unformatted records: each between two 32-bit byte counts
        Ascii
    };
    Form form = Form::Binary;
    bool big_endian = false;
};

struct GridWriteOptions {
    base::LengthUnit unit = base::LengthUnit::Millimetre;  ///< of the numbers in the file
    Plot3dOptions plot3d;
    /// Of surface grids: with_points() of the grid's plan, of velocities in mm a unit of time.
    /// Written beside the points; Plot3D files have no place for them.
    const Plan* velocities = nullptr;
    base::Progress progress;
};

/// Evaluates, measures and writes a grid, and adds the file to `outputs`.
/// @throw OutputError when it cannot be written, Cancelled; InvalidArgument for velocities of a
///        volume
GridQuality write_grid(const BlockSource& grid, const std::filesystem::path& file,
                       base::OutputSet& outputs, const GridWriteOptions& options = {});

/// The same with the file put in its place: it appears complete or not at all.
GridQuality write_grid(const BlockSource& grid, const std::filesystem::path& file,
                       const GridWriteOptions& options = {});

}  // namespace patchwright::grid
#pragma GCC visibility pop
