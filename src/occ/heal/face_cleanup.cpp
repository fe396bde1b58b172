#include "occ/heal/face_cleanup.h"

#include "occ/foot/face_surface.h"

#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepGProp.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>

#include <algorithm>
#include <cmath>

namespace patchwright::occ {

using geom::Vec3;

namespace {

// Of the size: faces nearer to each other than this are one.
constexpr double coincident_rel = 1e-6;
constexpr double same_area = 1e-5;
/// The centroid of a large face is known to fewer digits than the size has.
constexpr double centroid_reaches = 10.0;

struct Measures {
    TopoDS_Face face;
    double area = 0.0;
    double perimeter = 0.0;
    Vec3 centroid = Vec3::Zero();
};

Measures measure(const TopoDS_Face& face) {
    Measures result;
    result.face = face;
    GProp_GProps surface, border;
    BRepGProp::SurfaceProperties(face, surface);
    result.area = std::abs(surface.Mass());
    result.centroid = vec(surface.CentreOfMass());
    for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
        if (BRep_Tool::Degenerated(TopoDS::Edge(it.Current()))) continue;
        GProp_GProps edge;
        BRepGProp::LinearProperties(it.Current(), edge);
        result.perimeter += edge.Mass();
    }
    return result;
}

/// Some points within the face and on its border.
std::vector<Vec3> points_of(const TopoDS_Face& face, double size) {
    std::vector<Vec3> points;
    const FaceSurface surface(face, size);
    if (surface.unbounded()) return points;
    constexpr int cells = 7;
    for (int i = 0; i < cells * cells; ++i) {
        const Vec2 share((i % cells + 0.5) / cells, (i / cells + 0.5) / cells);
        const Vec2 uv = surface.low() + share.cwiseProduct(surface.high() - surface.low());
        if (surface.contains(uv)) points.push_back(surface.at(uv));
    }
    for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
        double first = 0.0, last = 0.0;
        const auto curve = BRep_Tool::Curve(TopoDS::Edge(it.Current()), first, last);
        if (!curve.IsNull()) points.push_back(vec(curve->Value(0.37 * first + 0.63 * last)));
    }
    return points;
}

bool lies_on(const std::vector<Vec3>& points, const TopoDS_Face& face, double tolerance) {
    return !points.empty() && std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
        const TopoDS_Vertex vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(p.x(), p.y(), p.z()));
        const BRepExtrema_DistShapeShape search(vertex, face, Extrema_ExtFlag_MIN);
        return search.IsDone() && search.Value() <= tolerance;
    });
}

bool same_place(const Measures& a, const Measures& b, double size) {
    if (std::abs(a.area - b.area) > same_area * std::max(a.area, b.area)) return false;
    const double reach = coincident_rel * size;
    if ((a.centroid - b.centroid).norm() > centroid_reaches * reach) return false;
    if (a.face.IsSame(b.face)) return true;
    return lies_on(points_of(a.face, size), b.face, reach) &&
           lies_on(points_of(b.face, size), a.face, reach);
}

std::vector<Measures> measures_of(const std::vector<TopoDS_Shape>& shapes) {
    std::vector<Measures> result;
    for (const TopoDS_Shape& shape : shapes) {
        for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
            result.push_back(measure(TopoDS::Face(it.Current())));
    }
    return result;
}

}  // namespace

CleanedParts drop_duplicates_and_slivers(const std::vector<TopoDS_Shape>& parts,
                                         const std::vector<TopoDS_Shape>& solids, double size,
                                         double sliver_rel) {
    std::vector<Measures> kept = measures_of(solids);
    const std::size_t in_solids = kept.size();
    CleanedParts result;
    for (const TopoDS_Shape& part : parts) {
        std::vector<TopoDS_Shape> left;
        bool whole = true;
        for (const Measures& face : measures_of({part})) {
            const bool sliver = 2.0 * face.area <= sliver_rel * size * face.perimeter;
            const bool again = !sliver && std::any_of(kept.begin(), kept.end(), [&](const auto& k) {
                return same_place(face, k, size);
            });
            result.slivers += sliver ? 1 : 0;
            result.duplicates += again ? 1 : 0;
            whole = whole && !sliver && !again;
            if (sliver || again) continue;
            left.push_back(face.face);
            kept.push_back(face);
        }
        if (whole) {
            result.parts.push_back(part);
        } else {
            result.parts.insert(result.parts.end(), left.begin(), left.end());
        }
    }
    if (kept.empty() && in_solids == 0) return {parts, 0, 0};
    return result;
}

}  // namespace patchwright::occ
