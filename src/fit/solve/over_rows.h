// Rows in parallel, in blocks whose sizes do not depend on the number of threads.
#pragma once

#include <patchwright/base/parallel.h>
#include <patchwright/geom/types.h>

namespace patchwright::fit {

/// Calls body(first, count) for blocks of at most `grain` rows.
template <std::size_t grain, class Body>
void over_rows(Eigen::Index rows, const Body& body) {
    base::parallel_for(std::size_t(rows), grain, [&](std::size_t first, std::size_t last) {
        body(Eigen::Index(first), Eigen::Index(last - first));
    });
}

}  // namespace patchwright::fit
