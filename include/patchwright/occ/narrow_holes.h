// Holes of CAD models that are narrower than what matters.
#pragma once

#include <patchwright/geom/types.h>
#include <patchwright/occ/cad_model.h>

#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::occ {

struct NarrowHole {
    geom::Vec3 at = geom::Vec3::Zero();  ///< middle of a rim, millimetres
    double width_mm = 0.0;               ///< largest distance between points of that rim
    int faces = 0;                       ///< inside; 0: a hole in a sheet
};

struct ModelWithoutHoles {
    CadModel model;                 ///< with the names and colours of the faces that stay
    std::vector<NarrowHole> holes;  ///< left out; none: the model is the given one
};

/// Closes holes whose rims, each an inner loop of a face, are at most so wide, and which are as
/// narrow inside: through holes, blind ones and holes in sheets. A narrow channel to a wide cavity
/// stays, as do pins.
ModelWithoutHoles without_narrow_holes(const CadModel& model, double width_mm);

}  // namespace patchwright::occ
#pragma GCC visibility pop
