// Solids and open shells from connected parts.
#pragma once

#include <patchwright/geom/types.h>

#include <TopoDS_Shape.hxx>
#include <TopoDS_Shell.hxx>

#include <vector>

namespace patchwright::occ {

/// Faces that hang together.
struct ShellPart {
    TopoDS_Shell shell;
    bool closed = false;
    double volume = 0.0;             ///< of its sign only; negative: faces look inward
    geom::Box3 box;                  ///< holds the faces
    std::vector<geom::Vec3> points;  ///< some of its vertices, from all over it
};

/// Open parts stay shells. A closed part becomes a solid, turned outward if need be, unless it lies
/// inside another: then it is a void of that one, and one inside a void is a solid again. Parts
/// that cross each other are solids of their own, as they may be in the model they come from.
std::vector<TopoDS_Shape> make_bodies(const std::vector<ShellPart>& parts);

}  // namespace patchwright::occ
