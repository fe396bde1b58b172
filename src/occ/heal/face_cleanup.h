// Faces that a file holds twice, and faces without width.
#pragma once

#include <TopoDS_Shape.hxx>

#include <vector>

namespace patchwright::occ {

struct CleanedParts {
    std::vector<TopoDS_Shape> parts;  ///< a part that lost faces comes apart into its faces
    int duplicates = 0;
    int slivers = 0;
};

/// Drops from loose parts the faces that lie on another face of the parts or of the solids (same
/// area and centroid, and points of one on the other), and slivers: faces whose mean width is below
/// `sliver_rel` of the size. A wall in which two bodies touch, with neighbours on either side,
/// stays twice. Something is always left.
/// @param size  millimetres; diagonal of the model
CleanedParts drop_duplicates_and_slivers(const std::vector<TopoDS_Shape>& parts,
                                         const std::vector<TopoDS_Shape>& solids, double size,
                                         double sliver_rel = 1e-6);

}  // namespace patchwright::occ
