// Even triangles of a wanted size that keep features, as the start of a cage.
#pragma once

#include "cage/remesh/size_field.h"

#include <patchwright/base/progress.h>

namespace patchwright::cage {

struct RemeshOptions {
    SizeOptions size;
    int rounds = 8;
    base::Progress progress;
};

/// Splits long edges, collapses short ones, flips and relaxes until edges have the lengths of the
/// size field. Feature curves keep their vertices on them, corners stay.
/// Source: Botsch and Kobbelt, A remeshing approach to multiresolution modeling (2004), with sizes
/// by curvature as in Dunyach et al., Adaptive remeshing for real-time mesh deformation (2013).
void remesh(TriMesh& mesh, const geom::ModelSurface& reference, const RemeshOptions& options);

}  // namespace patchwright::cage
