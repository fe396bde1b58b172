#include "model_edges.h"

#include <BRep_Tool.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::occ {

using geom::Vec3;

namespace {

double angle_between(const Vec3& a, const Vec3& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

struct EdgeIndex {
    TopTools_IndexedMapOfShape edges, vertices;
    std::vector<int> number;  ///< of the model edge by position in `edges`; -1: degenerate
};

ModelEdge make_edge(const TopoDS_Edge& edge, const TopTools_IndexedMapOfShape& vertices) {
    ModelEdge result;
    result.curve = BRep_Tool::Curve(edge, result.first, result.last);
    result.tolerance = BRep_Tool::Tolerance(edge);
    const TopoDS_Edge forward = TopoDS::Edge(edge.Oriented(TopAbs_FORWARD));
    const TopoDS_Vertex start = TopExp::FirstVertex(forward), end = TopExp::LastVertex(forward);
    if (!start.IsNull()) result.start = vertices.FindIndex(start) - 1;
    if (!end.IsNull()) result.end = vertices.FindIndex(end) - 1;
    return result;
}

void add_uses(EdgeNetwork& network, const EdgeIndex& index, const TopoDS_Face& face, int number) {
    const TopoDS_Face forward = TopoDS::Face(face.Oriented(TopAbs_FORWARD));
    for (TopExp_Explorer it(forward, TopAbs_EDGE); it.More(); it.Next()) {
        const TopoDS_Edge& edge = TopoDS::Edge(it.Current());
        const int slot = index.number[std::size_t(index.edges.FindIndex(edge)) - 1];
        if (slot < 0) continue;
        EdgeUse use;
        use.face = number;
        use.curve = BRep_Tool::CurveOnSurface(edge, forward, use.first, use.last);
        use.reversed =
            (edge.Orientation() == TopAbs_REVERSED) != (face.Orientation() == TopAbs_REVERSED);
        network.edges[std::size_t(slot)].uses.push_back(use);
    }
}

EdgeKind classify(const ModelEdge& edge, const std::vector<FaceSurface>& surfaces,
                  double sharp_angle_rad) {
    if (edge.uses.size() < 2) return EdgeKind::Free;
    if (edge.uses.size() > 2) return EdgeKind::Sharp;
    constexpr int samples = 9;
    std::vector<double> angles;
    for (int i = 0; i < samples; ++i) {
        const double t = edge.first + (edge.last - edge.first) * (i + 0.5) / samples;
        const Vec3 a = normal_beside(edge, edge.uses[0], t, surfaces);
        Vec3 b = normal_beside(edge, edge.uses[1], t, surfaces);
        // Faces of opposite orientation run along the edge in the same direction.
        if (edge.uses[0].reversed == edge.uses[1].reversed) b = -b;
        if (!a.isZero(0.0) && !b.isZero(0.0)) angles.push_back(angle_between(a, b));
    }
    if (angles.empty()) return EdgeKind::Smooth;
    const auto middle = angles.begin() + std::ptrdiff_t(angles.size() / 2);
    std::nth_element(angles.begin(), middle, angles.end());
    return *middle > sharp_angle_rad ? EdgeKind::Sharp : EdgeKind::Smooth;
}

std::vector<int> find_corners(const EdgeNetwork& network, double sharp_angle_rad) {
    // Directions in which features leave each vertex.
    std::vector<std::vector<Vec3>> ends(network.vertices.size());
    for (const ModelEdge& edge : network.edges) {
        if (edge.kind == EdgeKind::Smooth) continue;
        if (edge.start >= 0) ends[std::size_t(edge.start)].push_back(edge.tangent(edge.first));
        if (edge.end >= 0) ends[std::size_t(edge.end)].push_back(-edge.tangent(edge.last));
    }
    std::vector<int> corners;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        if (ends[i].empty()) continue;
        if (ends[i].size() != 2 || angle_between(ends[i][0], -ends[i][1]) > sharp_angle_rad)
            corners.push_back(int(i));
    }
    return corners;
}

}  // namespace

Vec3 ModelEdge::tangent(double t) const {
    gp_Pnt p;
    gp_Vec d;
    curve->D1(t, p, d);
    // A cusp of the parametrisation has a direction all the same: that of the chord beside it.
    const double off = (t < 0.5 * (first + last) ? 1e-4 : -1e-4) * (last - first);
    const Vec3 chord = (at(t + off) - vec(p)) * (off > 0.0 ? 1.0 : -1.0);
    const Vec3 derivative = vec(d);
    const bool usable = derivative.norm() * std::abs(off) > 1e-3 * chord.norm();
    return (usable ? derivative : chord).normalized();
}

Vec3 normal_beside(const ModelEdge& edge, const EdgeUse& use, double t,
                   const std::vector<FaceSurface>& surfaces) {
    if (use.curve.IsNull()) return Vec3::Zero();
    const double s = (t - edge.first) / (edge.last - edge.first);
    const Vec2 uv = vec(use.curve->Value(use.first + s * (use.last - use.first)));
    return surfaces[std::size_t(use.face)].normal(uv);
}

EdgeNetwork collect_edges(const TopoDS_Shape& shape, const std::vector<TopoDS_Face>& faces,
                          const std::vector<FaceSurface>& surfaces, double sharp_angle_rad) {
    EdgeNetwork network;
    EdgeIndex index;
    TopExp::MapShapes(shape, TopAbs_EDGE, index.edges);
    TopExp::MapShapes(shape, TopAbs_VERTEX, index.vertices);
    for (int i = 1; i <= index.vertices.Extent(); ++i)
        network.vertices.push_back(vec(BRep_Tool::Pnt(TopoDS::Vertex(index.vertices(i)))));
    for (int i = 1; i <= index.edges.Extent(); ++i) {
        const TopoDS_Edge& edge = TopoDS::Edge(index.edges(i));
        index.number.push_back(-1);
        if (BRep_Tool::Degenerated(edge)) continue;
        ModelEdge made = make_edge(edge, index.vertices);
        if (made.curve.IsNull() || !(made.first < made.last)) continue;
        index.number.back() = int(network.edges.size());
        network.edges.push_back(std::move(made));
    }
    for (std::size_t i = 0; i < faces.size(); ++i) add_uses(network, index, faces[i], int(i));
    std::erase_if(network.edges, [](const ModelEdge& edge) { return edge.uses.empty(); });
    for (ModelEdge& edge : network.edges) edge.kind = classify(edge, surfaces, sharp_angle_rad);
    network.corners = find_corners(network, sharp_angle_rad);
    return network;
}

}  // namespace patchwright::occ
