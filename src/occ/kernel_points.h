// Between the kernel's point types and the project's.
#pragma once

#include <patchwright/geom/types.h>

#include <gp_Pnt.hxx>
#include <gp_Pnt2d.hxx>
#include <gp_Vec.hxx>

namespace patchwright::occ {

using Vec2 = Eigen::Vector2d;

inline geom::Vec3 vec(const gp_XYZ& p) { return {p.X(), p.Y(), p.Z()}; }
inline geom::Vec3 vec(const gp_Pnt& p) { return vec(p.XYZ()); }
inline geom::Vec3 vec(const gp_Vec& v) { return vec(v.XYZ()); }
inline Vec2 vec(const gp_Pnt2d& p) { return {p.X(), p.Y()}; }

}  // namespace patchwright::occ
