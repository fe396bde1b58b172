#include "occ/heal/face_cleanup.h"

#include "geom/disjoint_sets.h"
#include "occ/foot/face_surface.h"
#include "occ/heal/sewing.h"

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepGProp.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

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

/// All faces, those in one place known as such.
class FacePlaces {
  public:
    FacePlaces(std::vector<Measures> faces, double size)
        : faces_(std::move(faces)), size_(size), boxes_(faces_.size()) {
        std::vector<std::size_t> places;
        for (std::size_t i = 0; i < faces_.size(); ++i) {
            const auto first = std::find_if(places.begin(), places.end(), [&](std::size_t place) {
                return same_place(faces_[i], faces_[place], size);
            });
            place_of_.push_back(first == places.end() ? i : *first);
            if (first == places.end()) places.push_back(i);
            BRepBndLib::Add(faces_[i].face, boxes_[i]);
            boxes_[i].Enlarge(reach());
        }
        find_walls();
    }

    /// The faces in one place with the face, numbered from 0 in their order.
    [[nodiscard]] std::size_t number_in_place(std::size_t face) const {
        return std::size_t(std::count(place_of_.begin(), place_of_.begin() + std::ptrdiff_t(face),
                                      place_of_[face]));
    }

    /// Whether two bodies touch here: faces that are there twice and hang together have neighbours
    /// in two other places along most of their border.
    [[nodiscard]] bool is_wall(std::size_t face) const { return walls_.count(place_of_[face]) > 0; }

  private:
    using Places = std::set<std::size_t>;

    /// As far as neighbours that sewing joins are from each other.
    [[nodiscard]] double reach() const { return SewingOptions{}.max_partly_rel * size_; }

    void find_walls() {
        Places twice;
        for (std::size_t i = 0; i < faces_.size(); ++i)
            if (place_of_[i] != i) twice.insert(place_of_[i]);
        if (twice.empty()) return;
        struct Border {
            int edges = 0, between = 0;  ///< between: of two bodies
        };
        std::map<std::size_t, Border> borders;
        geom::DisjointSets groups(faces_.size());
        for (const std::size_t place : twice) {
            for (const gp_Pnt& at : middles_of_edges(faces_[place].face)) {
                const Places beside = places_beside(place, at);
                Places once;
                for (const std::size_t other : beside) {
                    if (twice.count(other) > 0)
                        groups.join(int(place), int(other));
                    else
                        once.insert(other);
                }
                if (once.empty()) continue;
                ++borders[place].edges;
                borders[place].between += once.size() >= 2 ? 1 : 0;
            }
        }
        std::map<int, Border> of_groups;
        for (const auto& [place, border] : borders) {
            Border& sum = of_groups[groups.find(int(place))];
            sum.edges += border.edges;
            sum.between += border.between;
        }
        for (const std::size_t place : twice) {
            const Border& border = of_groups[groups.find(int(place))];
            if (2 * border.between > border.edges) walls_.insert(place);
        }
    }

    static std::vector<gp_Pnt> middles_of_edges(const TopoDS_Face& face) {
        std::vector<gp_Pnt> middles;
        for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
            double first = 0.0, last = 0.0;
            const auto curve = BRep_Tool::Curve(TopoDS::Edge(it.Current()), first, last);
            if (!curve.IsNull()) middles.push_back(curve->Value((first + last) / 2));
        }
        return middles;
    }

    /// The places other than one in which there are faces with an edge at a point.
    [[nodiscard]] Places places_beside(std::size_t place, const gp_Pnt& at) const {
        Places found;
        const TopoDS_Vertex vertex = BRepBuilderAPI_MakeVertex(at);
        for (std::size_t i = 0; i < faces_.size(); ++i) {
            if (place_of_[i] == place || boxes_[i].IsOut(at)) continue;
            for (TopExp_Explorer it(faces_[i].face, TopAbs_EDGE); it.More(); it.Next()) {
                const BRepExtrema_DistShapeShape search(vertex, it.Current(), Extrema_ExtFlag_MIN);
                if (search.IsDone() && search.Value() <= reach()) found.insert(place_of_[i]);
            }
        }
        return found;
    }

    std::vector<Measures> faces_;
    double size_;
    std::vector<Bnd_Box> boxes_;
    std::vector<std::size_t> place_of_;  ///< by face: the first face in its place
    Places walls_;
};

}  // namespace

CleanedParts drop_duplicates_and_slivers(const std::vector<TopoDS_Shape>& parts,
                                         const std::vector<TopoDS_Shape>& solids, double size,
                                         double sliver_rel) {
    std::vector<Measures> faces = measures_of(solids);
    std::size_t number = faces.size();
    std::vector<std::vector<Measures>> by_part;
    for (const TopoDS_Shape& part : parts) by_part.push_back(measures_of({part}));
    // Slivers have no place.
    const auto is_sliver = [&](const Measures& face) {
        return 2.0 * face.area <= sliver_rel * size * face.perimeter;
    };
    for (const auto& part : by_part)
        std::remove_copy_if(part.begin(), part.end(), std::back_inserter(faces), is_sliver);
    if (faces.empty()) return {parts, 0, 0};
    const FacePlaces places(std::move(faces), size);
    CleanedParts result;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        std::vector<TopoDS_Shape> left;
        for (const Measures& face : by_part[p]) {
            if (is_sliver(face)) {
                ++result.slivers;
                continue;
            }
            const std::size_t before = places.number_in_place(number);
            if (before > 1 || (before == 1 && !places.is_wall(number)))
                ++result.duplicates;
            else
                left.push_back(face.face);
            ++number;
        }
        const bool whole = left.size() == by_part[p].size();
        if (whole) {
            result.parts.push_back(parts[p]);
        } else {
            result.parts.insert(result.parts.end(), left.begin(), left.end());
        }
    }
    return result;
}

}  // namespace patchwright::occ
