#include "occ/brep/mass.h"

#include "occ/kernel_points.h"

#include <patchwright/base/parallel.h>
#include <patchwright/geom/bspline.h>

#include <BRepGProp.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>

#include <algorithm>
#include <cmath>
#include <vector>

namespace patchwright::occ {

namespace {

geom::BsplineSurface from_kernel(const Handle(Geom_BSplineSurface) & given) {
    const auto spline = Handle(Geom_BSplineSurface)::DownCast(given->Copy());
    if (spline->IsUPeriodic()) spline->SetUNotPeriodic();
    if (spline->IsVPeriodic()) spline->SetVNotPeriodic();
    const TColStd_Array1OfReal &u = spline->UKnotSequence(), &v = spline->VKnotSequence();
    geom::BsplineSurface surface{{u.begin(), u.end()}, {v.begin(), v.end()}, {}};
    surface.points.resize(surface.rows() * surface.columns(), 3);
    for (int i = 0; i < int(surface.rows()); ++i)
        for (int j = 0; j < int(surface.columns()); ++j)
            surface.point(i, j) = vec(spline->Pole(i + 1, j + 1)).transpose();
    return surface;
}

/// 1 where the solid lies behind the face's surface, -1 before it, 0 on both sides or none.
double side_of_solid(const TopoDS_Shape& face) {
    switch (face.Orientation()) {
        case TopAbs_FORWARD: return 1.0;
        case TopAbs_REVERSED: return -1.0;
        default: return 0.0;
    }
}

geom::Vec3 any_vertex(const TopoDS_Shape& shape) {
    const TopExp_Explorer it(shape, TopAbs_VERTEX);
    return it.More() ? vec(BRep_Tool::Pnt(TopoDS::Vertex(it.Current())))
                     : geom::Vec3(geom::Vec3::Zero());
}

/// A face with the part of its surface in the whole.
struct FaceUse {
    TopoDS_Face face;
    double side;  ///< see side_of_solid(); 0 outside of solids
    geom::SurfaceMoments moments = {};
};

std::vector<FaceUse> face_uses(const TopoDS_Shape& shape) {
    std::vector<FaceUse> uses;
    for (TopExp_Explorer it(shape, TopAbs_SOLID); it.More(); it.Next())
        for (TopExp_Explorer face(it.Current(), TopAbs_FACE); face.More(); face.Next())
            uses.push_back({TopoDS::Face(face.Current()), side_of_solid(face.Current())});
    for (TopExp_Explorer face(shape, TopAbs_FACE, TopAbs_SOLID); face.More(); face.Next())
        uses.push_back({TopoDS::Face(face.Current()), 0.0});
    return uses;
}

Mass kernel_mass(const TopoDS_Shape& shape) {
    GProp_GProps area, volume;
    BRepGProp::SurfaceProperties(shape, area);
    for (TopExp_Explorer it(shape, TopAbs_SOLID); it.More(); it.Next()) {
        GProp_GProps of_solid;
        BRepGProp::VolumeProperties(it.Current(), of_solid);
        volume.Add(of_solid);
    }
    return {area.Mass(), volume.Mass(), vec((volume.Mass() > 0.0 ? volume : area).CentreOfMass())};
}

}  // namespace

Handle(Geom_BSplineSurface) whole_bicubic(const TopoDS_Face& face) {
    Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
    if (const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface);
        !trimmed.IsNull()) {
        surface = trimmed->BasisSurface();
    }
    const auto spline = Handle(Geom_BSplineSurface)::DownCast(surface);
    if (spline.IsNull() || spline->IsURational() || spline->IsVRational() ||
        spline->UDegree() != 3 || spline->VDegree() != 3) {
        return nullptr;
    }
    double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
    spline->Bounds(u0, u1, v0, v1);
    const auto on_border = [&](const gp_Pnt2d& p) {
        const double u = std::min(p.X() - u0, u1 - p.X()) / (u1 - u0);
        const double v = std::min(p.Y() - v0, v1 - p.Y()) / (v1 - v0);
        return std::min(std::abs(u), std::abs(v)) < 1e-6;
    };
    // Every boundary curve lies on the border, and together they are as long as it is.
    double covered = 0.0;
    for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
        double first = 0, last = 0;
        const Handle(Geom2d_Curve) curve =
            BRep_Tool::CurveOnSurface(TopoDS::Edge(it.Current()), face, first, last);
        if (curve.IsNull()) return nullptr;
        for (const double s : {0.0, 0.3, 0.5, 0.7, 1.0}) {
            if (!on_border(curve->Value(first + s * (last - first)))) return nullptr;
        }
        const gp_Vec2d chord(curve->Value(first), curve->Value(last));
        covered += std::abs(chord.X()) / (u1 - u0) + std::abs(chord.Y()) / (v1 - v0);
    }
    return std::abs(covered - 4.0) < 1e-6 ? spline : nullptr;
}

Mass measure_mass(const TopoDS_Shape& shape) {
    std::vector<FaceUse> uses = face_uses(shape);
    const auto is_bicubic = [](const FaceUse& use) { return !whole_bicubic(use.face).IsNull(); };
    if (!std::all_of(uses.begin(), uses.end(), is_bicubic)) return kernel_mass(shape);
    const geom::Vec3 origin = any_vertex(shape);  // near by: the parts of the volume cancel less
    base::parallel_for(uses.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k)
            uses[k].moments = geom::moments(from_kernel(whole_bicubic(uses[k].face)), origin);
    });
    geom::SurfaceMoments whole;
    for (const auto& [face, side, part] : uses) {
        whole.area += part.area;
        whole.of_area += part.of_area;
        whole.volume += side * part.volume;
        whole.of_volume += side * part.of_volume;
    }
    Mass mass{whole.area, whole.volume, origin};
    if (whole.volume > 0.0)
        mass.centroid += whole.of_volume / whole.volume;
    else if (whole.area > 0.0)
        mass.centroid += whole.of_area / whole.area;
    return mass;
}

}  // namespace patchwright::occ
