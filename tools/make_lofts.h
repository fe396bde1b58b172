// B-spline surfaces through points, and their borders: what the generators of CAD are made of.
#pragma once

#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <gp_Pnt.hxx>

#include <functional>
#include <vector>

namespace lofts {

using Curve = Handle(Geom_BSplineCurve);
using Surface = Handle(Geom_BSplineSurface);

/// Tensor product interpolation: sections[j][i] is the point at parameters u[i] and v[j]. Cubic;
/// linear where there are two, quadratic where there are three parameters.
Surface loft(const std::vector<std::vector<gp_Pnt>>& sections, const std::vector<double>& u,
             const std::vector<double>& v);

/// The part of a surface between parameters, which may be all of it.
Surface part(const Surface& surface, double u0, double u1, double v0, double v1);

Curve as_spline(const Handle(Geom_Curve) & curve);
Curve line(const gp_Pnt& a, const gp_Pnt& b);
Surface ruled(const Curve& first, const Curve& second);

/// Half ellipses from `upper` to `lower`, curves of the same knots. `outward` gives the axis of the
/// ellipse from its centre and from half the way from lower to upper.
Surface rounded_cap(const Curve& upper, const Curve& lower,
                    const std::function<gp_XYZ(const gp_XYZ& centre, const gp_XYZ& half)>& outward);

/// The face of all of a surface.
TopoDS_Face face_of(const Surface& surface);

/// @throw runtime_error when the faces are not connected
TopoDS_Shell sewn(const std::vector<TopoDS_Face>& faces);

/// @throw runtime_error when the faces do not close or the solid is not valid
TopoDS_Solid sewn_solid(const std::vector<TopoDS_Face>& faces);

}  // namespace lofts
