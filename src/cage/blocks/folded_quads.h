// Quads of a cage that fold, and what becomes of a layout whose quads do.
#pragma once

#include "cage/blocks.h"
#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

#include <string>
#include <vector>

namespace patchwright::cage {

/// Half the cross product of the diagonals.
geom::Vec3 quad_area(const Blocks& blocks, std::size_t face);
geom::Vec3 quad_middle(const Blocks& blocks, std::size_t face);
/// Of a quad's four corners, as seen against its own normal.
double least_sine(const Blocks& blocks, std::size_t face);

/// Quads must face as the model does and may be concave a little, at one corner: the fit makes that
/// good. What has two such corners is folded.
std::vector<std::size_t> folded_quads(const Blocks& blocks, const geom::ModelSurface& reference,
                                      Poll& poll);

/// Share of quads that fold above which moving points opens some of them only and is not worth its
/// time, nor are finer edges.
constexpr double most_folded = 0.04;

/// Gives quads the names of the faces that they are on.
/// @param face_names  one a face of the model
/// @param for_good    whether LayoutRefused says so when more than most_folded fold
/// @throw LayoutRefused when quads fold
Blocks checked(Blocks blocks, const geom::ModelSurface& reference,
               const std::vector<std::string>& face_names, bool for_good, Poll& poll);

}  // namespace patchwright::cage
