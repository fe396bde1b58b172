// How fast the distance falls with refinement, and what local quasi-interpolation leaves.
#pragma once

#include <nlohmann/json.hpp>

namespace patchwright::bench {

/// Fits on ever finer cages of a sphere, a torus, a NACA wing and a smoother one: distances by
/// region and their orders in the width of the faces, measured and expected.
nlohmann::ordered_json orders();

/// On the NACA wing: local quasi-interpolation and full least squares by CGLS, time and distance.
nlohmann::ordered_json quasi_interpolation();

}  // namespace patchwright::bench
