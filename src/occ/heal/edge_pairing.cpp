#include "occ/heal/edge_pairing.h"

#include "occ/kernel_points.h"

#include <BRepTools_ReShape.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_Curve.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

namespace patchwright::occ {

namespace {

struct Use {
    int face;
    bool forward;
};

struct PlacedEdge {
    TopoDS_Edge edge;
    std::vector<Use> uses;
    bool in_pair = false;
};

class Model {
  public:
    explicit Model(const TopoDS_Shape& shape) {
        TopExp::MapShapes(shape, TopAbs_FACE, faces_);
        TopTools_IndexedMapOfShape map;
        for (int f = 1; f <= faces_.Extent(); ++f) {
            for (TopExp_Explorer it(faces_(f), TopAbs_EDGE); it.More(); it.Next()) {
                const TopoDS_Edge& edge = TopoDS::Edge(it.Current());
                if (BRep_Tool::Degenerated(edge)) continue;
                const auto number = std::size_t(map.Add(edge));
                if (number > edges_.size())
                    edges_.push_back({TopoDS::Edge(edge.Oriented(TopAbs_FORWARD)), {}});
                edges_[number - 1].uses.push_back({f - 1, edge.Orientation() == TopAbs_FORWARD});
            }
        }
    }

    /// Pairs of edges in one place with two uses each by four faces.
    std::vector<std::array<std::size_t, 2>> find_pairs(double tolerance) {
        TopTools_IndexedMapOfShape vertices;
        std::multimap<std::array<int, 2>, std::size_t> by_ends;
        std::vector<std::array<std::size_t, 2>> pairs;
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            const TopoDS_Vertex a = TopExp::FirstVertex(edges_[i].edge),
                                b = TopExp::LastVertex(edges_[i].edge);
            if (a.IsNull() || b.IsNull() || edges_[i].uses.size() != 2) continue;
            std::array<int, 2> ends{vertices.Add(a), vertices.Add(b)};
            if (ends[0] > ends[1]) std::swap(ends[0], ends[1]);
            const auto [first, last] = by_ends.equal_range(ends);
            for (auto it = first; it != last; ++it) {
                PlacedEdge &one = edges_[it->second], &other = edges_[i];
                if (one.in_pair || !same_place(one.edge, other.edge, tolerance)) continue;
                one.in_pair = other.in_pair = true;
                pairs.push_back({it->second, i});
                break;
            }
            by_ends.emplace(ends, i);
        }
        return pairs;
    }

    /// Whether each face must be turned to agree with the first of its part, by edges not in pairs.
    void find_sides() {
        std::vector<std::vector<std::pair<int, bool>>> neighbours(std::size_t(faces_.Extent()));
        for (const PlacedEdge& edge : edges_) {
            if (edge.in_pair || edge.uses.size() != 2) continue;
            const auto &a = edge.uses[0], &b = edge.uses[1];
            const bool agree = a.forward != b.forward;
            neighbours[std::size_t(a.face)].emplace_back(b.face, agree);
            neighbours[std::size_t(b.face)].emplace_back(a.face, agree);
        }
        part_.assign(neighbours.size(), -1);
        turned_.assign(neighbours.size(), false);
        for (std::size_t seed = 0; seed < neighbours.size(); ++seed) {
            if (part_[seed] >= 0) continue;
            std::vector<std::size_t> queue{seed};
            part_[seed] = int(seed);
            for (std::size_t next = 0; next < queue.size(); ++next) {
                for (const auto& [face, agrees] : neighbours[queue[next]]) {
                    const auto f = std::size_t(face);
                    if (part_[f] >= 0) continue;
                    part_[f] = int(seed);
                    turned_[f] = turned_[queue[next]] != !agrees;
                    queue.push_back(f);
                }
            }
        }
    }

    /// Changes who shares which of two edges; false when all is well or nothing better is known.
    bool rejoin(const std::array<std::size_t, 2>& pair,
                std::map<int, std::vector<std::array<TopoDS_Edge, 2>>>& by_face) {
        const PlacedEdge &one = edges_[pair[0]], &other = edges_[pair[1]];
        const bool reversed = runs_reversed(one.edge, other.edge);
        std::array<Use, 4> uses{one.uses[0], one.uses[1], other.uses[0], other.uses[1]};
        for (std::size_t i : {2u, 3u}) uses[i].forward = uses[i].forward != reversed;
        for (std::size_t i = 1; i < 4; ++i)
            if (part_[std::size_t(uses[i].face)] != part_[std::size_t(uses[0].face)]) return false;
        const auto fits = [&](std::size_t a, std::size_t b) {
            return (uses[a].forward != turned_[std::size_t(uses[a].face)]) !=
                   (uses[b].forward != turned_[std::size_t(uses[b].face)]);
        };
        if (fits(0, 1) && fits(2, 3)) return false;
        for (const std::size_t partner : {2u, 3u}) {
            const std::size_t left = 5 - partner;
            if (!fits(0, partner) || !fits(1, left)) continue;
            // The partner takes the first edge, and the first edge's other face the second.
            by_face[uses[partner].face].push_back({other.edge, one.edge});
            by_face[uses[1].face].push_back({one.edge, other.edge});
            return true;
        }
        return false;
    }

    /// The face with one edge instead of another in the same place.
    static TopoDS_Face exchange(const TopoDS_Face& face, const TopoDS_Edge& old_edge,
                                const TopoDS_Edge& new_edge) {
        const TopoDS_Face forward = TopoDS::Face(face.Oriented(TopAbs_FORWARD));
        double first = 0.0, last = 0.0;
        Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(old_edge, forward, first, last);
        if (curve.IsNull()) return face;
        const bool reversed = runs_reversed(old_edge, new_edge);
        if (reversed) {
            curve = Handle(Geom2d_Curve)::DownCast(curve->Copy());
            const double from = curve->ReversedParameter(last),
                         to = curve->ReversedParameter(first);
            curve->Reverse();
            first = from;
            last = to;
        }
        const BRep_Builder builder;
        const double tolerance =
            std::max(BRep_Tool::Tolerance(old_edge), BRep_Tool::Tolerance(new_edge));
        builder.UpdateEdge(new_edge, curve, forward, tolerance);
        builder.Range(new_edge, forward, first, last);
        BRepTools_ReShape change;
        change.Replace(old_edge, reversed ? new_edge.Reversed() : TopoDS_Shape(new_edge));
        return TopoDS::Face(change.Apply(face));
    }

    [[nodiscard]] TopoDS_Face face(int number) const { return TopoDS::Face(faces_(number + 1)); }

  private:
    static bool runs_reversed(const TopoDS_Edge& a, const TopoDS_Edge& b) {
        return !TopExp::FirstVertex(a).IsSame(TopExp::FirstVertex(b));
    }

    /// Relative difference of parameter ranges that is rounding.
    static constexpr double same_range = 1e-9;

    static bool same_place(const TopoDS_Edge& a, const TopoDS_Edge& b, double tolerance) {
        double a0 = 0, a1 = 0, b0 = 0, b1 = 0;
        const Handle(Geom_Curve) one = BRep_Tool::Curve(a, a0, a1),
                                 other = BRep_Tool::Curve(b, b0, b1);
        if (one.IsNull() || other.IsNull()) return false;
        // P-curves can be exchanged only if both edges run at the same speed over as long a range.
        if (std::abs((a1 - a0) - (b1 - b0)) > same_range * (a1 - a0)) return false;
        const bool reversed = runs_reversed(a, b);
        for (const double s : {0.25, 0.5, 0.75}) {
            const double t = reversed ? b1 - s * (b1 - b0) : b0 + s * (b1 - b0);
            if ((vec(one->Value(a0 + s * (a1 - a0))) - vec(other->Value(t))).norm() > tolerance)
                return false;
        }
        return true;
    }

    TopTools_IndexedMapOfShape faces_;
    std::vector<PlacedEdge> edges_;
    std::vector<int> part_;
    std::vector<bool> turned_;
};

}  // namespace

int pair_coincident_edges(TopoDS_Shape& shape, double tolerance, FaceOrigins& origins) {
    Model model(shape);
    const auto pairs = model.find_pairs(tolerance);
    if (pairs.empty()) return 0;
    model.find_sides();
    int changed = 0;
    BRepTools_ReShape changes;
    std::map<int, std::vector<std::array<TopoDS_Edge, 2>>> by_face;
    for (const auto& pair : pairs) changed += model.rejoin(pair, by_face) ? 1 : 0;
    if (changed == 0) return 0;
    for (const auto& [number, exchanges] : by_face) {
        const TopoDS_Face before = model.face(number);
        TopoDS_Face after = before;
        for (const auto& [old_edge, new_edge] : exchanges)
            after = Model::exchange(after, old_edge, new_edge);
        changes.Replace(before, after);
        origins.replaced(before, after);
    }
    shape = changes.Apply(shape);
    return changed;
}

}  // namespace patchwright::occ
