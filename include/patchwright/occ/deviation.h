// Two-sided deviation of two CAD models.
#pragma once

#include <patchwright/fit/deviation.h>
#include <patchwright/occ/cad_reference.h>

namespace patchwright::occ {

/// From `from`, sampled at about `samples` points, to `to`. Points where a face normal exists are
/// matched plainly to the nearest point, whatever its side.
fit::Deviation measure_deviation(const CadReference& from, const CadReference& to, int samples,
                                 const base::Progress& progress = {});

}  // namespace patchwright::occ
