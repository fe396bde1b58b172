// The form of the sample wing, and its cage.
#pragma once

#include <gp_Pnt.hxx>
#include <gp_Vec.hxx>

#include <string>

namespace sample_wing {

inline constexpr double cap_aspect = 2.0;  // length of the cap over the tip's half thickness

/// What variants of the wing differ in.
struct WingShape {
    double span_mm = 2800;     ///< root to where the rounded cap begins
    double sweep = 0.36;       ///< way aft by way outboard
    double tip_bend_mm = 0;    ///< of the tip upwards; grows with the square of the way outboard
    double tip_twist_deg = 0;  ///< more than the sample's, nose up; grows with the way outboard
    double thickness = 1;      ///< times the sample's
};

/// Point of the wing's skin. `s` runs along the section from the lower trailing edge (-1) over the
/// nose (0) to the upper trailing edge (1), with the chord fraction s * s; `eta` from root to tip.
/// Section: NACA four digits (Jacobs, Ward and Pinkerton, NACA report 460, 1933), blunted linearly.
gp_Pnt skin_point(double s, double eta, const WingShape& shape = {});

/// Direction of the span in the middle of the section, with y = 1.
gp_Vec span_direction(double chord_fraction, const WingShape& shape = {});

/// A box of quads around the wing: chordwise rows of stations on both sides, a strip each for the
/// nose, the trailing edge, the tip and the root.
/// @throw runtime_error when the file cannot be written
void write_cage(const std::string& path);

}  // namespace sample_wing
