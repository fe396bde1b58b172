// Lines through points, measured by arc length.
#pragma once

#include <patchwright/geom/types.h>

#include <vector>

namespace patchwright::geom {

using Polyline = std::vector<Vec3>;

double length_of(const Polyline& line);
/// At each point, from 0.  @pre there are points
std::vector<double> arc_lengths(const Polyline& line);
/// The same as shares of its length, 0 to 1.
std::vector<double> arc_length_shares(const Polyline& line);
/// At a share of its length.  @pre there are points
Vec3 point_along(const Polyline& line, double share);
/// The part between two shares of its length.
Polyline part_of(const Polyline& line, double from, double to);
/// Not more than 128 points, the first and the last among them.
Polyline thinned(const Polyline& line);
/// Infinite for less than two points.
double distance_to(const Polyline& line, const Vec3& q);

}  // namespace patchwright::geom
