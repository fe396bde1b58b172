// What is rounded too tightly for the faces of a cage.
#pragma once

namespace patchwright::cage {

/// Radius as a fraction of the diagonal. Edges of cages are at least 8e-3 of the diagonal long
/// (SizeOptions::least_rel), which is more than a quarter turn of a smaller radius can hold: such a
/// rounding becomes a line of the cage instead.
inline constexpr double tight_radius_rel = 6e-3;

}  // namespace patchwright::cage
