#include "geom/disjoint_sets.h"
#include "occ/exchange/cad_model_impl.h"

#include <patchwright/occ/narrow_holes.h>

#include <BRepAdaptor_Curve.hxx>
#include <BRepGProp.hxx>
#include <BRepTools.hxx>
#include <BRepTools_ReShape.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>
#include <TopTools_MapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Wire.hxx>

#include <algorithm>
#include <map>

namespace patchwright::occ {

namespace {

using geom::Vec3;

/// An inner loop of a face.
struct Rim {
    std::size_t face;
    TopoDS_Wire wire;
    std::vector<Vec3> points;  ///< with the face's inside on their left
    double width_mm = 0.0;

    [[nodiscard]] Vec3 middle() const {
        Vec3 sum = Vec3::Zero();
        for (const Vec3& p : points) sum += p;
        return sum / double(points.size());
    }
    /// Of what closes the rim, along its normal, which is the opposite of the face's.
    [[nodiscard]] Vec3 area() const {
        const Vec3 origin = middle();
        Vec3 twice = Vec3::Zero();
        for (std::size_t i = 0; i < points.size(); ++i)
            twice += (points[i] - origin).cross(points[(i + 1) % points.size()] - origin);
        return 0.5 * twice;
    }
};

std::vector<Vec3> points_of(const TopoDS_Wire& wire, const TopoDS_Face& face) {
    constexpr int an_edge = 8;
    std::vector<Vec3> points;
    for (BRepTools_WireExplorer it(wire, face); it.More(); it.Next()) {
        const TopoDS_Edge& edge = it.Current();
        if (BRep_Tool::Degenerated(edge)) continue;
        const BRepAdaptor_Curve curve(edge);
        double first = curve.FirstParameter(), last = curve.LastParameter();
        if (edge.Orientation() == TopAbs_REVERSED) std::swap(first, last);
        for (int i = 0; i < an_edge; ++i) {
            const gp_Pnt p = curve.Value(first + (last - first) * i / an_edge);
            points.emplace_back(p.X(), p.Y(), p.Z());
        }
    }
    return points;
}

/// Beyond the limit only some width beyond it.
double width_of(const std::vector<Vec3>& points, double limit) {
    double most = 0.0;
    for (std::size_t i = 0; i < points.size() && most <= limit; ++i)
        for (std::size_t j = i + 1; j < points.size(); ++j)
            most = std::max(most, (points[i] - points[j]).norm());
    return most;
}

std::vector<Rim> narrow_rims(const std::vector<TopoDS_Face>& faces, double width_mm) {
    std::vector<Rim> rims;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const TopoDS_Wire outer = BRepTools::OuterWire(faces[f]);
        for (TopoDS_Iterator it(faces[f]); it.More(); it.Next()) {
            if (it.Value().ShapeType() != TopAbs_WIRE || it.Value().IsSame(outer)) continue;
            Rim rim{f, TopoDS::Wire(it.Value()), {}};
            rim.points = points_of(rim.wire, faces[f]);
            rim.width_mm = width_of(rim.points, width_mm);
            if (rim.points.size() > 2 && rim.width_mm <= width_mm) rims.push_back(std::move(rim));
        }
    }
    return rims;
}

/// The faces that hang together by other edges than those of rims, as sets of numbers, and the
/// faces beside each rim, on its other side.
struct Parts {
    std::vector<std::vector<int>> faces;
    std::vector<int> of_face;
    std::vector<std::vector<int>> beside;  ///< rims; parts

    Parts(const std::vector<TopoDS_Face>& all, const std::vector<Rim>& rims) {
        TopTools_DataMapOfShapeInteger rim_of;
        for (std::size_t r = 0; r < rims.size(); ++r)
            for (TopExp_Explorer it(rims[r].wire, TopAbs_EDGE); it.More(); it.Next())
                rim_of.Bind(it.Current(), int(r));
        geom::DisjointSets together(all.size());
        TopTools_DataMapOfShapeInteger first;
        std::vector<std::vector<int>> across(rims.size());
        for (std::size_t f = 0; f < all.size(); ++f) {
            for (TopExp_Explorer it(all[f], TopAbs_EDGE); it.More(); it.Next()) {
                if (BRep_Tool::Degenerated(TopoDS::Edge(it.Current()))) continue;
                if (const int* rim = rim_of.Seek(it.Current())) {
                    if (rims[std::size_t(*rim)].face != f)
                        across[std::size_t(*rim)].push_back(int(f));
                } else if (const int* other = first.Seek(it.Current())) {
                    together.join(*other, int(f));
                } else {
                    first.Bind(it.Current(), int(f));
                }
            }
        }
        faces = together.sets();
        of_face.resize(all.size());
        for (std::size_t p = 0; p < faces.size(); ++p)
            for (const int f : faces[p]) of_face[std::size_t(f)] = int(p);
        for (const std::vector<int>& others : across) {
            std::vector<int>& parts = beside.emplace_back();
            for (const int f : others) parts.push_back(of_face[std::size_t(f)]);
            std::sort(parts.begin(), parts.end());
            parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
        }
    }
};

/// Four times the volume that faces and rims enclose over the faces' area: of a tube, its diameter;
/// negative where the faces have it on their inner side.
double hydraulic_diameter(const std::vector<TopoDS_Face>& all, const std::vector<int>& inside,
                          const std::vector<const Rim*>& rims) {
    const BRep_Builder builder;
    TopoDS_Shell shell;
    builder.MakeShell(shell);
    for (const int f : inside) builder.Add(shell, all[std::size_t(f)]);
    const Vec3 origin = rims.front()->middle();
    GProp_GProps area, volume(gp_Pnt(origin.x(), origin.y(), origin.z()));
    BRepGProp::SurfaceProperties(shell, area);
    BRepGProp::VolumeProperties(shell, volume);
    double closed = volume.Mass();
    for (const Rim* rim : rims) closed += (rim->middle() - origin).dot(rim->area()) / 3.0;
    return -4.0 * closed / area.Mass();
}

/// The model without some loops and faces.
CadModel without(const CadModel& model, const std::vector<TopoDS_Face>& all,
                 const std::vector<const Rim*>& rims, const std::vector<int>& gone) {
    BRepTools_ReShape change;
    TopTools_DataMapOfShapeInteger number;  // of faces that stay
    for (std::size_t f = 0; f < all.size(); ++f) number.Bind(all[f], int(f));
    std::map<std::size_t, TopTools_MapOfShape> loops;
    for (const Rim* rim : rims) loops[rim->face].Add(rim->wire);
    const BRep_Builder builder;
    for (const auto& [f, closed] : loops) {
        const TopoDS_Shape forward = all[f].Oriented(TopAbs_FORWARD);
        TopoDS_Shape face = forward.EmptyCopied();
        for (TopoDS_Iterator it(forward); it.More(); it.Next())
            if (!closed.Contains(it.Value())) builder.Add(face, it.Value());
        change.Replace(forward, face);
        number.Bind(face, int(f));
    }
    for (const int f : gone) change.Remove(all[std::size_t(f)]);
    auto impl = std::make_shared<CadModel::Impl>();
    impl->shape = change.Apply(model.impl().shape);
    const CadModel result(impl);
    const auto names = face_names(model);
    const auto colours = face_colours(model);
    for (const TopoDS_Face& face : faces_of(result)) {
        const int* f = number.Seek(face);
        impl->face_names.push_back(f == nullptr ? std::string() : names[std::size_t(*f)]);
        impl->face_colours.push_back(f == nullptr ? std::nullopt : colours[std::size_t(*f)]);
    }
    return result;
}

}  // namespace

ModelWithoutHoles without_narrow_holes(const CadModel& model, double width_mm) {
    const std::vector<TopoDS_Face> faces = faces_of(model);
    const std::vector<Rim> rims = narrow_rims(faces, width_mm);
    ModelWithoutHoles result{model, {}};
    if (rims.empty()) return result;
    const Parts parts(faces, rims);
    std::vector<const Rim*> closed;
    std::vector<int> gone;
    const auto close = [&](const std::vector<const Rim*>& rims_of, const std::vector<int>& inside) {
        const Rim& first = *rims_of.front();
        result.holes.push_back({first.middle(), first.width_mm, int(inside.size())});
        closed.insert(closed.end(), rims_of.begin(), rims_of.end());
        gone.insert(gone.end(), inside.begin(), inside.end());
    };
    // By the part inside. A rim that leads nowhere is a hole in a sheet.
    std::map<int, std::vector<const Rim*>> by_part;
    for (std::size_t r = 0; r < rims.size(); ++r) {
        const std::vector<int>& beside = parts.beside[r];
        if (beside.empty()) close({&rims[r]}, {});
        if (beside.size() == 1) by_part[beside.front()].push_back(&rims[r]);
    }
    for (const auto& [part, of_part] : by_part) {
        const int outside = parts.of_face[of_part.front()->face];
        const bool leads_on = std::any_of(of_part.begin(), of_part.end(), [&](const Rim* rim) {
            return parts.of_face[rim->face] != outside;
        });
        if (outside == part || leads_on) continue;
        const std::vector<int>& inside = parts.faces[std::size_t(part)];
        const double diameter = hydraulic_diameter(faces, inside, of_part);
        if (diameter > 0.0 && diameter <= width_mm) close(of_part, inside);
    }
    if (!result.holes.empty()) result.model = without(model, faces, closed, gone);
    return result;
}

}  // namespace patchwright::occ
