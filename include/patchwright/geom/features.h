// Feature curves and corners: where a shape has no tangent plane, or ends.
#pragma once

#include <patchwright/geom/types.h>

#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::geom {

/// Dihedral deviation from flat above which an edge of CAD faces is sharp: 20 degrees.
inline constexpr double default_sharp_angle_rad = 0.349;

/// Dihedral deviation from flat above which a smooth curve is a bend: 2 degrees, more than tangent
/// faces of legacy files are off by.
inline constexpr double least_bend_rad = 0.035;

enum class FeatureKind {
    Sharp,   ///< curve where two faces meet at an angle
    Free,    ///< curve where the surface ends
    Smooth,  ///< curve where two faces meet in one tangent plane
    Corner   ///< point where features meet or end at an angle
};

/// A maximal run of edges of one kind without a corner inside, parametrised by arc length.
struct FeatureCurve {
    FeatureKind kind = FeatureKind::Sharp;  ///< Sharp, Free or Smooth
    double length = 0.0;                    ///< millimetres
    bool closed = false;                    ///< ends where it starts
    /// Numbers of the corners at arc length 0 and `length`. -1: no corner there; a closed curve
    /// without a corner starts anywhere.
    int start_corner = -1, end_corner = -1;
    Vec3 start = Vec3::Zero(), end = Vec3::Zero();
    /// Dihedral deviation from flat along a sharp or smooth curve, by samples at the true edges;
    /// radians, 0 for free curves.
    double least_angle_rad = 0.0, greatest_angle_rad = 0.0;
};

enum class CornerKind {
    Junction,  ///< features meet at an angle
    End,       ///< one feature ends within a smooth surface
    Cusp,      ///< two of its features leave it in almost the same direction
    Apex       ///< no feature leaves it, but the surface has no tangent plane (tip of a cone)
};

struct FeatureCorner {
    Vec3 point = Vec3::Zero();
    CornerKind kind = CornerKind::Junction;
    std::vector<int> curves;  ///< sharp and free ones that start or end here; twice if both
};

struct Features {
    std::vector<FeatureCurve> curves;
    std::vector<FeatureCorner> corners;
};

/// Nearest point of a feature curve or corner.
struct FeaturePoint {
    Vec3 point = Vec3::Zero();
    double distance = 0.0;        ///< |query - point|, >= 0
    int feature = -1;             ///< number among Features::curves or corners
    double arc_length = 0.0;      ///< along the curve, 0 to its length; 0 for corners
    Vec3 tangent = Vec3::Zero();  ///< unit, in the direction of growing arc length; 0 for corners
};

/// A piece of a curve. On a closed curve `to` may exceed its length and `from` may be negative: the
/// piece then runs across the start.
struct ArcRange {
    double from = 0.0, to = 0.0;
};

}  // namespace patchwright::geom
#pragma GCC visibility pop
