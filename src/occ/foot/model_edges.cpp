#include "occ/foot/model_edges.h"

#include "geom/angle.h"

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
#include <optional>

namespace patchwright::occ {

using geom::Vec3;

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
        FaceOfEdge use;
        use.face = number;
        use.curve = BRep_Tool::CurveOnSurface(edge, forward, use.first, use.last);
        use.reversed =
            (edge.Orientation() == TopAbs_REVERSED) != (face.Orientation() == TopAbs_REVERSED);
        network.edges[std::size_t(slot)].uses.push_back(use);
    }
}

/// How far from flat the two faces beside the edge are at `t`; empty where one has no normal.
/// @pre the edge has two uses
std::optional<double> dihedral(const ModelEdge& edge, double t,
                               const std::vector<FaceSurface>& surfaces) {
    const Vec3 a = normal_beside(edge, edge.uses[0], t, surfaces);
    Vec3 b = normal_beside(edge, edge.uses[1], t, surfaces);
    // Faces of opposite orientation run along the edge in the same direction.
    if (edge.uses[0].reversed == edge.uses[1].reversed) b = -b;
    if (a.isZero(0.0) || b.isZero(0.0)) return std::nullopt;
    return geom::angle_between(a, b);
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
        if (const auto angle = dihedral(edge, t, surfaces)) angles.push_back(*angle);
    }
    if (angles.empty()) return;
    std::sort(angles.begin(), angles.end());
    edge.least_angle = angles.front();
    edge.greatest_angle = angles.back();
    if (angles[angles.size() / 2] > sharp_angle_rad) edge.kind = EdgeKind::Sharp;
}

/// Where along an edge of two faces sharp turns to smooth or back, rising. Runs shorter than an
/// eighth of the edge do not count, nor do edges that change more than twice: their angle is about
/// the limit all along.
std::vector<double> sharpness_changes(const ModelEdge& edge,
                                      const std::vector<FaceSurface>& surfaces,
                                      double sharp_angle_rad) {
    constexpr int samples = 33, shortest_run = 4, bisections = 30;
    if (edge.uses.size() != 2) return {};
    const auto parameter = [&](double k) {
        return edge.first + (edge.last - edge.first) * (k + 0.5) / samples;
    };
    const auto is_sharp = [&](double t) {
        const auto angle = dihedral(edge, t, surfaces);
        return angle && *angle > sharp_angle_rad;
    };
    std::vector<double> changes;
    bool sharp = is_sharp(parameter(0));
    for (int k = 1, run = 1; k < samples; ++k, ++run) {
        if (is_sharp(parameter(k)) == sharp) continue;
        if (run < shortest_run || samples - k < shortest_run) return {};
        double before = parameter(k - 1), after = parameter(k);
        for (int step = 0; step < bisections; ++step) {
            const double middle = 0.5 * (before + after);
            (is_sharp(middle) == sharp ? before : after) = middle;
        }
        changes.push_back(after);
        sharp = !sharp;
        run = 0;
    }
    return changes.size() <= 2 ? changes : std::vector<double>{};
}

/// Edges that are sharp on part of their length become several, with vertices between them.
void split_by_sharpness(EdgeNetwork& network, const std::vector<FaceSurface>& surfaces,
                        double sharp_angle_rad) {
    std::vector<ModelEdge> split;
    for (const ModelEdge& edge : network.edges) {
        std::vector<double> ends = sharpness_changes(edge, surfaces, sharp_angle_rad);
        ends.push_back(edge.last);
        double start = edge.first;
        int start_vertex = edge.start;
        for (const double end : ends) {
            ModelEdge part = edge;
            part.first = start;
            part.last = end;
            part.start = start_vertex;
            if (end != edge.last) {
                part.end = int(network.vertices.size());
                network.vertices.push_back(edge.at(end));
            }
            const auto share = [&](double t) {
                return (t - edge.first) / (edge.last - edge.first);
            };
            for (FaceOfEdge& use : part.uses) {
                const double length = use.last - use.first, first = use.first;
                use.first = first + share(start) * length;
                use.last = first + share(end) * length;
            }
            split.push_back(std::move(part));
            start = end;
            start_vertex = split.back().end;
        }
    }
    network.edges = std::move(split);
}

/// What features leave a vertex, and in which directions.
struct VertexDirections {
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
                if (geom::angle_between(directions[i], directions[j]) < sharp_angle_rad)
                    return geom::CornerKind::Cusp;
        const bool straight = directions.size() == 2 && sharp != free &&
                              geom::angle_between(directions[0], -directions[1]) <= sharp_angle_rad;
        if (straight) return std::nullopt;
        return geom::CornerKind::Junction;
    }
};

std::vector<NetworkCorner> find_corners(const EdgeNetwork& network, const std::vector<char>& apex) {
    std::vector<VertexDirections> features(network.vertices.size());
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
    constexpr double beside = 1e-4;       // of the edge's range
    constexpr double least_speed = 1e-3;  // of the chord's, below which a derivative is rounding
    const double off = (t < 0.5 * (first + last) ? beside : -beside) * (last - first);
    const Vec3 chord = (at(t + off) - vec(p)) * (off > 0.0 ? 1.0 : -1.0);
    const Vec3 derivative = vec(d);
    const bool usable = derivative.norm() * std::abs(off) > least_speed * chord.norm();
    return (usable ? derivative : chord).normalized();
}

Vec2 parameters_beside(const ModelEdge& edge, const FaceOfEdge& use, double t) {
    if (use.curve.IsNull()) return Vec2::Zero();
    const double s = (t - edge.first) / (edge.last - edge.first);
    return vec(use.curve->Value(use.first + s * (use.last - use.first)));
}

Vec3 normal_beside(const ModelEdge& edge, const FaceOfEdge& use, double t,
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
        made.shape_edge = i - 1;
        network.edges.push_back(std::move(made));
    }
    for (std::size_t i = 0; i < faces.size(); ++i) add_uses(network, index, faces[i], int(i));
    std::erase_if(network.edges, [](const ModelEdge& edge) { return edge.uses.empty(); });
    split_by_sharpness(network, surfaces, sharp_angle_rad);
    for (ModelEdge& edge : network.edges) classify(edge, surfaces, sharp_angle_rad);
    network.sharp_angle_rad = sharp_angle_rad;
    std::vector<char> apex = find_apexes(index, faces, surfaces);
    apex.resize(network.vertices.size(), 0);
    network.corners = find_corners(network, apex);
    return network;
}

}  // namespace patchwright::occ
