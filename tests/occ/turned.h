// Bodies of revolution, for tests that see no kernel.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <array>
#include <vector>

namespace patchwright::test {

/// A Bezier curve turned around the z axis: one face. @param profile  radius and height of its
/// poles
occ::CadModel turned(const std::vector<std::array<double, 2>>& profile);

}  // namespace patchwright::test
