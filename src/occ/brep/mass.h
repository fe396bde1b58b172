// Area, volume and centroid of shapes.
#pragma once

#include <patchwright/geom/types.h>

#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

namespace patchwright::occ {

/// The face's surface where that is a non-rational bicubic B-spline trimmed by nothing, else null.
Handle(Geom_BSplineSurface) whole_bicubic(const TopoDS_Face& face);

struct Mass {
    double area_mm2 = 0.0;
    double volume_mm3 = 0.0;  ///< sum over the solids
    geom::Vec3 centroid =
        geom::Vec3::Zero();  ///< of the volume; of the area where that is not positive
};

/// By the kernel, but from the surfaces alone where every face has a whole_bicubic(): that is exact
/// and takes a fraction of the time.
Mass measure_mass(const TopoDS_Shape& shape);

}  // namespace patchwright::occ
