// What a cage's rule at creases changes.
#pragma once

#include <patchwright/mesh/cage.h>

#pragma GCC visibility push(default)
namespace patchwright::measure {

/// Largest distance of the limit surface's tangent planes from the points at equal parameters that
/// mesh::CreaseRule::CatmullClark makes of the same control points, from 5 x 5 points a face: by
/// how much programs that know no other rule show the surface elsewhere. 0 where the rule acts
/// nowhere.
double distance_from_catmull_clark(const mesh::Cage& cage);

}  // namespace patchwright::measure
#pragma GCC visibility pop
