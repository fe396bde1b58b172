// Parts that aircraft are made of, and whole aircraft by seed.
//
// Axes: x aft, y to the right wing, z up; the plane of symmetry is y = 0. Lengths in millimetres.
#pragma once

#include "make_lofts.h"

#include <TopoDS_Shape.hxx>
#include <gp_Trsf.hxx>

#include <array>
#include <random>
#include <string>
#include <vector>

namespace aircraft {

/// An airfoil of unit chord by class and shape functions (B. Kulfan, Universal parametric geometry
/// representation method, Journal of Aircraft 45, 2008), with Bernstein polynomials of degree 3.
struct Airfoil {
    std::array<double, 4> upper{}, lower{};  ///< the first of both is equal: a smooth nose
    double base = 0.0;                       ///< thickness of the trailing edge
};

/// A section of a wing: the airfoil turned by `twist` about the nose, then by `roll` about x, which
/// is 0 in wings and a right angle in fins. Radians.
struct Station {
    gp_Pnt nose;
    double chord = 0.0, twist = 0.0, roll = 0.0;
    Airfoil airfoil;
};

enum class Tip { Plane, Rounded };

/// A wing from root to tip. Panels meet in equal stations and may meet at an angle; inside of one
/// the skin is smooth.
struct Wing {
    std::vector<std::vector<Station>> panels;
    bool smooth_root = false;  ///< no kink at the root where its mirror image joins
    Tip tip = Tip::Plane;
    bool closed_root = false;  ///< a rib closes the root
};

/// Four-sided faces that close but for the root: upper and lower skins, the trailing edge, the tip.
std::vector<TopoDS_Face> faces_of(const Wing& wing);

/// Faces, and mirror images of them at y = 0.
std::vector<TopoDS_Face> with_mirror_image(const std::vector<TopoDS_Face>& faces);
TopoDS_Shape mirror_image(const TopoDS_Shape& shape);

/// A fuselage: elliptic nose, straight barrel, tail that rises and tapers to a rounded end.
struct Fuselage {
    double length = 0.0, radius = 0.0, nose_length = 0.0, tail_length = 0.0;
    double tail_radius = 0.0, tail_rise = 0.0;
    double height_ratio = 1.0;  ///< of the sections, to their width
};

/// The right half; it closes with its mirror image.
std::vector<TopoDS_Face> faces_of(const Fuselage& fuselage);

/// A flow-through nacelle: an airfoil turned around a line along x.
struct Nacelle {
    gp_Pnt intake_centre;
    double radius = 0.0, length = 0.0;
    Airfoil airfoil;  ///< its upper side is the outer one
};

TopoDS_Solid solid_of(const Nacelle& nacelle);

enum class Borders {
    Trimmed,   ///< parts are fused
    Untrimmed  ///< one skin of faces with natural borders
};
enum class Extent {
    Whole,    ///< a closed solid
    OpenHalf  ///< a shell: the right half, open at the plane of symmetry
};

/// By kind: flying_wing, blended_wing_body, wing_body_tails, wing_body_nacelles, components.
/// @throw invalid_argument when there is no such kind, or none with these borders or extent
/// @throw runtime_error when the seed's parts do not make one valid solid
TopoDS_Shape make_aircraft(const std::string& kind, unsigned seed, Borders borders, Extent extent);

}  // namespace aircraft
