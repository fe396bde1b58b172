// Fits the parts of a cage that are not connected, each to its own surface.
#pragma once

#include <patchwright/fit/fit.h>

#pragma GCC visibility push(default)
namespace patchwright::fit {

/// One part before and after.
struct PartFit {
    mesh::Cage given;
    const geom::ReferenceSurface* reference = nullptr;
    FitOptions options;
    FitResult result;
};

struct PartsFit {
    /// Of all parts together: figures of a level are sums and maxima over the parts, of which
    /// those with fewer levels stay at their last one; the last level holds the best of each.
    FitResult whole;
    std::vector<PartFit> parts;
};

/// Parts are refined until they meet the tolerance, whatever the others do. Those of the same
/// surface are fitted together, as one PartFit: only all of them cover it.
/// @param references  one a part
/// @param known  earlier results: a part that is the same, to be fitted in the same way, is taken
///               from there
/// Once options.progress throws base::TimeLimitReached, parts that have no level yet are measured
/// as they were given; see FitResult::stopped_by_time_limit.
/// @throw InvalidArgument as fit(), and when the numbers of parts and references differ
/// @throw TimeLimitReached when there is no level of the first part yet
PartsFit fit_parts(const std::vector<mesh::Cage>& parts,
                   const std::vector<const geom::ReferenceSurface*>& references,
                   const FitOptions& options, const std::vector<PartFit>& known = {});

}  // namespace patchwright::fit
#pragma GCC visibility pop
