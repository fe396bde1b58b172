// Whether two pieces of surfaces meet, and where.
#pragma once

#include "measure/bezier_piece.h"

#include <optional>

namespace patchwright::measure {

/// A point of two pieces with its parameters on both.
struct PieceMeeting {
    geom::Vec3 point = geom::Vec3::Zero();
    std::array<Eigen::Vector2d, 2> uv;
};

/// Whether a plane parts them but for `slack_mm`: all points of one are less far beyond it. False
/// may also mean that none was found in a few steps.
bool are_apart(const BezierPiece& a, const BezierPiece& b, double slack_mm);

/// A common point by Newton steps of least length from the middles of the pieces.
/// @param exact_mm  how near two points are that count as one
std::optional<PieceMeeting> meeting_point(const BezierPiece& a, const BezierPiece& b,
                                          double exact_mm);

/// Whether the surface stays within `reach_mm` of a point on the straight way between parameters.
bool stays_near(const geom::BsplineSurface& surface, const geom::Vec3& point,
                const Eigen::Vector2d& from, const Eigen::Vector2d& to, double reach_mm);

/// Whether it does so on the way to one of its sides.
bool is_beside_side(const geom::BsplineSurface& surface, const geom::Vec3& point,
                    const Eigen::Vector2d& uv, double reach_mm);

}  // namespace patchwright::measure
