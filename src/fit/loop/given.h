// A cage measured without being fitted.
#pragma once

#include <patchwright/fit/fit.h>

namespace patchwright::fit {

/// One level, the given cage: what stands for a fit that there is no time for.
FitResult measure_given(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                        const FitOptions& options);

}  // namespace patchwright::fit
