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

double angle_between(const Vec3& a, const Vec3& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

namespace {

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

void classify(ModelEdge& edge, const std::vector<FaceSurface>& surfaces, double sharp_angle_rad) {
    edge.kind = edge.uses.size() < 2   ? EdgeKind::Free
                : edge.uses.size() > 2 ? EdgeKind::Sharp
                                       : EdgeKind::Smooth;
    if (edge.uses.size() < 2) return;
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
    if (angles.empty()) return;
    std::sort(angles.begin(), angles.end());
    edge.least_angle = angles.front();
    edge.greatest_angle = angles.back();
    if (angles[angles.size() / 2] > sharp_angle_rad) edge.kind = EdgeKind::Sharp;
}

/// What features leave a vertex, and in which directions.
struct VertexFeatures {
    std::vector<Vec3> directions;
    bool sharp = false, free = false;

    void add(EdgeKind kind, const Vec3& direction) {
        directions.push_back(direction);
        (kind == EdgeKind::Sharp ? sharp : free) = true;
    }
    [[nodiscard]] std::optional<geom::CornerKind> corner(double sharp_angle_rad) const {
        if (directions.empty()) return std::nullopt;
        if (directions.size() == 1) return geom::CornerKind::End;
        for (std::size_t i = 0; i < directions.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (angle_between(directions[i], directions[j]) < sharp_angle_rad)
                    return geom::CornerKind::Cusp;
        const bool straight = directions.size() == 2 && sharp != free &&
                              angle_between(directions[0], -directions[1]) <= sharp_angle_rad;
        if (straight) return std::nullopt;
        return geom::CornerKind::Junction;
    }
};

std::vector<NetworkCorner> find_corners(const EdgeNetwork& network, const std::vector<char>& apex) {
    std::vector<VertexFeatures> features(network.vertices.size());
    for (const ModelEdge& edge : network.edges) {
        if (edge.kind == EdgeKind::Smooth) continue;
        if (edge.start >= 0)
            features[std::size_t(edge.start)].add(edge.kind, edge.tangent(edge.first));
        if (edge.end >= 0) features[std::size_t(edge.end)].add(edge.kind, -edge.tangent(edge.last));
    }
    std::vector<NetworkCorner> corners;
    for (std::size_t i = 0; i < features.size(); ++i) {
        if (const auto kind = features[i].corner(network.sharp_angle_rad)) {
            corners.push_back({int(i), *kind});
        } else if (apex[i] != 0) {
            corners.push_back({int(i), geom::CornerKind::Apex});
        }
    }
    return corners;
}

/// Vertices that a face's side shrinks to without a tangent plane.
std::vector<char> find_apexes(const EdgeIndex& index, const std::vector<TopoDS_Face>& faces,
                              const std::vector<FaceSurface>& surfaces) {
    std::vector<char> apex(std::size_t(index.vertices.Extent()), 0);
    for (std::size_t i = 0; i < faces.size(); ++i) {
        if (surfaces[i].unbounded()) continue;
        for (TopExp_Explorer it(faces[i], TopAbs_EDGE); it.More(); it.Next()) {
            const TopoDS_Edge& edge = TopoDS::Edge(it.Current());
            if (!BRep_Tool::Degenerated(edge)) continue;
            double first = 0.0, last = 0.0;
            const auto curve = BRep_Tool::CurveOnSurface(edge, faces[i], first, last);
            const TopoDS_Vertex vertex = TopExp::FirstVertex(edge);
            if (curve.IsNull() || vertex.IsNull()) continue;
            if (surfaces[i].normal(vec(curve->Value(0.5 * (first + last)))).isZero(0.0))
                apex[std::size_t(index.vertices.FindIndex(vertex)) - 1] = 1;
        }
    }
    return apex;
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

Vec2 parameters_beside(const ModelEdge& edge, const EdgeUse& use, double t) {
    if (use.curve.IsNull()) return Vec2::Zero();
    const double s = (t - edge.first) / (edge.last - edge.first);
    return vec(use.curve->Value(use.first + s * (use.last - use.first)));
}

Vec3 normal_beside(const ModelEdge& edge, const EdgeUse& use, double t,
                   const std::vector<FaceSurface>& surfaces) {
    if (use.curve.IsNull()) return Vec3::Zero();
    return surfaces[std::size_t(use.face)].normal(parameters_beside(edge, use, t));
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
    for (ModelEdge& edge : network.edges) classify(edge, surfaces, sharp_angle_rad);
    network.sharp_angle_rad = sharp_angle_rad;
    network.corners = find_corners(network, find_apexes(index, faces, surfaces));
    return network;
}

}  // namespace patchwright::occ
