// Faces of a cage whose limit surface faces elsewhere than the shape that it approximates.
#pragma once

#include <patchwright/geom/reference_surface.h>
#include <patchwright/mesh/cage.h>

#include <vector>

namespace patchwright::measure {

/// One a face (of all sectors where it is no quad): how many samples are folded, as find_folds()
/// says; denser towards the face's corners. Creases of the cage do not count as edges.
std::vector<int> folded_samples(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                                double tolerance_mm);

}  // namespace patchwright::measure
