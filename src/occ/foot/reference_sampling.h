// Points spread over a model, for measuring it against another one.
#pragma once

#include "occ/foot/foot_point_engine.h"

#include <patchwright/occ/cad_reference.h>

#include <vector>

namespace patchwright::occ {

/// See CadReference::sample().
std::vector<geom::SurfaceSample> sample_model(const SearchModel& model, int count);

}  // namespace patchwright::occ
