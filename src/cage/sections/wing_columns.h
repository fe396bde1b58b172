// Where the points of a wing's sections are.
#pragma once

#include "cage/sections/wing_section.h"

#include <vector>

namespace patchwright::cage {

/// The same shares of the sides' lengths in all rings, from the trailing edge: dense at the nose;
/// where no line runs on it, its points lie where the section has turned by about 50 degrees.
/// @pre there are sections
std::vector<double> column_shares(const std::vector<WingSection>& sections, int columns);

}  // namespace patchwright::cage
