// Cuts along edges of a piece that are rounded tightly.
#pragma once

#include "cage/blocks/cuts.h"
#include "cage/blocks/piece_mesh.h"
#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

#include <optional>
#include <vector>

namespace patchwright::cage {

/// Lines of noses that run through pieces from border to border, as on the skin of a wing in one
/// piece: where the surface is bent too tightly for faces of a cage, but across only, and only in a
/// narrow strip.
class CrestCuts {
  public:
    CrestCuts(const PieceMesh& mesh, const geom::ModelSurface& reference, Poll& poll);

    /// The longest one of a piece; nothing when there is none.
    /// @pre vertices of the mesh have not moved since the first call
    [[nodiscard]] std::optional<Cut> longest(const CutPiece& piece);

  private:
    /// The surface's curvature across a crest, times the radius that is too small; 0 where there is
    /// none.
    [[nodiscard]] double bend_at(int vertex);

    const PieceMesh& mesh_;
    const geom::ModelSurface& reference_;
    Poll& poll_;
    double tightest_;           ///< radius, mm
    std::vector<double> bend_;  ///< by vertex; negative: not known yet
};

}  // namespace patchwright::cage
