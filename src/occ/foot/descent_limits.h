// Where Newton's method for foot points, on curves and on surfaces, stops.
#pragma once

namespace patchwright::occ {

// Lengths are fractions of the model's size. The bars are those of tests/occ/foot_point_oracle_test
// (the kernel's own extrema to 1e-9 of the size).

/// Convergence is quadratic: what follows a step this short is below rounding.
inline constexpr double final_step_rel = 1e-8;
/// Shorter steps move nothing: some bits above the rounding of coordinates.
inline constexpr double no_step_rel = 1e-13;
/// Rounding of evaluated points, with a margin for long polynomials.
inline constexpr double rounding_rel = 1e-12;
/// A Hessian counts as positive definite above this fraction of its Gauss-Newton part: below it
/// Newton's steps are too long to be of use.
inline constexpr double definite_fraction = 1e-9;

}  // namespace patchwright::occ
