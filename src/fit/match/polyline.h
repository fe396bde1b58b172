// Lines through points, as chains of sharp edges are compared with feature curves.
#pragma once

#include <patchwright/geom/types.h>

#include <vector>

namespace patchwright::fit {

using Polyline = std::vector<geom::Vec3>;

double length_of(const Polyline& line);
/// At a share of its length.  @pre there are points
geom::Vec3 point_along(const Polyline& line, double share);
/// The part between two shares of its length.
Polyline part_of(const Polyline& line, double from, double to);
/// Not more than 128 points, the first and the last among them.
Polyline thinned(const Polyline& line);
/// Infinite for less than two points.
double distance_to(const Polyline& line, const geom::Vec3& q);

}  // namespace patchwright::fit
