// Where the points of a wing's sections and tips are.
#pragma once

#include "cage/sections/wing_section.h"

#include <vector>

namespace patchwright::cage {

/// The same shares of the sides' lengths in all rings, from the trailing edge: dense at the nose;
/// where no line runs on it, its points lie where the section has turned by about 50 degrees.
/// @pre there are sections
std::vector<double> column_shares(const std::vector<WingSection>& sections, int columns);

/// How far a body goes on from a point inside, at most to the end of a way from there.
/// @return millimetres along the way
double way_out(const geom::Vec3& from, const geom::Vec3& way, const geom::ModelSurface& reference);

}  // namespace patchwright::cage
