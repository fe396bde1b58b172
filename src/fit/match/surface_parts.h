// The parts of a reference between its sharp curves, and which of them a face of a cage belongs to.
#pragma once

#include "fit/match/feature_match.h"

namespace patchwright::fit {

/// Creases part a cage as the curves that they follow part the reference: what is on one side of
/// such a crease belongs to the reference's part on the same side of its curve. On thin parts and
/// beside trailing edges the nearest point, and one that faces alike, is often on another part.
class SurfaceParts {
  public:
    SurfaceParts(const mesh::Topology& topology, const CurveSampling& curves,
                 const FeatureMatch& match, const geom::ReferenceSurface& reference);

    /// The part that a face of the cage belongs to: one flag a face of the reference. Null where
    /// the creases around the face do not tell, or nothing parts the reference.
    [[nodiscard]] const std::vector<char>* part_of(mesh::FaceId face) const;

  private:
    std::vector<std::vector<char>> parts_;  ///< one flag a face of the reference each
    std::vector<int> part_of_face_;         ///< one a face of the cage; -1: any
};

}  // namespace patchwright::fit
