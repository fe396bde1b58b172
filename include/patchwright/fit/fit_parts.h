// Fits of the bodies of a model, as one.
#pragma once

#include <patchwright/fit/fit.h>

#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::fit {

/// The fits of several cages as that of one cage: figures of a level are sums and maxima over the
/// parts, of which those with fewer levels stay at their last one; the last level holds the best
/// of each.
/// @throw InvalidArgument when there are none
FitResult joined(const std::vector<FitResult>& parts);

/// One level, the given cage: what stands for a fit that there is no time for.
FitResult measure_given(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                        const FitOptions& options);

}  // namespace patchwright::fit
#pragma GCC visibility pop
