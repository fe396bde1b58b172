// Even triangles of a wanted size that keep features, as the start of a cage.
#pragma once

#include "cage/remesh/size_field.h"

namespace patchwright::cage {

struct RemeshOptions {
    SizeOptions size;
    /// Of splitting, collapsing, flipping and relaxing: lengths settle in five to ten (Botsch and
    /// Kobbelt).
    int rounds = 8;
};

/// Splits long edges, collapses short ones, flips and relaxes until edges have the lengths of the
/// size field. Feature curves keep their vertices on them, corners stay.
/// Source: Botsch and Kobbelt, A remeshing approach to multiresolution modeling (2004), with sizes
/// by curvature as in Dunyach et al., Adaptive remeshing for real-time mesh deformation (2013).
void remesh(geom::EditableMesh& mesh, const geom::ModelSurface& reference,
            const RemeshOptions& options, Poll& poll);

}  // namespace patchwright::cage
