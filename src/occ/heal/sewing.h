// Sewing with a tolerance that the gaps between the faces ask for.
#pragma once

#include "occ/exchange/face_origins.h"

#include <patchwright/base/progress.h>

#include <TopoDS_Shape.hxx>

#include <vector>

namespace patchwright::occ {

struct SewingOptions {
    double size = 0.0;             ///< millimetres; diagonal of the faces
    double max_partly_rel = 1e-4;  ///< gaps up to this fraction of the size are closed anyway
    double max_wholly_rel = 1e-3;  ///< larger ones up to this only if nothing stays open then
    base::Progress progress;
};

struct Sewn {
    TopoDS_Shape shape;  ///< null when every tolerance would have removed faces
    double tolerance = 0.0;
    int free_edges = 0;
};

/// Measures the gap of every free edge and tries tolerances just above each cluster of gaps, the
/// smallest first; takes the first that leaves the fewest free edges. Tolerances that remove faces
/// or join more than two are passed over.
/// @pre parts hold faces; some of their edges are free
Sewn sew_by_gaps(const std::vector<TopoDS_Shape>& parts, const SewingOptions& options,
                 FaceOrigins& origins);

}  // namespace patchwright::occ
