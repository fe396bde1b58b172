#include "occ/heal/edge_pairing.h"

#include "geom/angle.h"
#include "geom/disjoint_sets.h"
#include "occ/kernel_points.h"

#include <BRepTools_ReShape.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BSplCLib.hxx>
#include <Geom2dConvert.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <GeomAPI_ProjectPointOnCurve.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
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

/// Two edges in one place, by number.
struct EdgePair {
    std::size_t first, second;
    bool reversed;  ///< the second runs the other way
    /// From one place of both into the faces that use the first and the second, at right angles.
    std::array<geom::Vec3, 4> into{};
};

/// The part of a curve from `first` to `last`, backwards if asked, over another range.
Handle(Geom2d_Curve) over_range(const Handle(Geom2d_Curve) & curve, double first, double last,
                                bool reversed, double new_first, double new_last) {
    Handle(Geom2d_BSplineCurve) spline =
        Geom2dConvert::CurveToBSplineCurve(new Geom2d_TrimmedCurve(curve, first, last));
    if (reversed) spline->Reverse();
    TColStd_Array1OfReal knots(1, spline->NbKnots());
    spline->Knots(knots);
    BSplCLib::Reparametrize(new_first, new_last, knots);
    spline->SetKnots(knots);
    return Handle(Geom2d_Curve)(spline);
}

/// The nearest point of an edge, but for its ends.
struct Place {
    std::optional<double> parameter;
    double distance = 0.0;

    Place(const TopoDS_Edge& edge, const gp_Pnt& point) {
        double first = 0.0, last = 0.0;
        const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
        if (curve.IsNull()) return;
        const GeomAPI_ProjectPointOnCurve nearest(point, curve, first, last);
        if (nearest.NbPoints() == 0) return;
        parameter = nearest.LowerDistanceParameter();
        distance = nearest.LowerDistance();
    }
};

/// One edge in place of another.
struct EdgeChange {
    TopoDS_Edge from, to;
    bool reversed;
};

/// Angles that differ by less, in radians, are equal.
constexpr double same_angle = 1e-3;

/// The four uses of a pair of edges, two of the first and two of the second, as seen along the
/// first: the first use belongs to `partner`, the others belong together.
struct Joining {
    std::size_t partner = 1;
    int apart = 0;        ///< of both joints: those of faces that do not lie on each other
    int known = 0;        ///< of both joints: those of faces that hang together elsewhere too
    double widest = 0.0;  ///< the larger of the angles between joined faces; radians

    [[nodiscard]] bool better_than(const Joining& other) const {
        if (apart != other.apart) return apart > other.apart;
        if (known != other.known) return known > other.known;
        return widest < other.widest - same_angle;
    }
};

/// Parts of faces that hang together, each face as it is or turned so that all run their common
/// edges in opposite directions.
class OrientedParts {
  public:
    explicit OrientedParts(std::size_t faces = 0) : sets_(2 * faces) {}

    void join(const Use& a, const Use& b) {
        sets_.join(as_is(a), turned(b));
        sets_.join(turned(a), as_is(b));
    }
    [[nodiscard]] bool joined(const Use& a, const Use& b) {
        return sets_.find(as_is(a)) == sets_.find(turned(b));
    }
    /// Both faces are in one part, and run the edge in one direction there.
    [[nodiscard]] bool contradict(const Use& a, const Use& b) {
        return sets_.find(as_is(a)) == sets_.find(as_is(b));
    }

  private:
    static int as_is(const Use& use) { return 2 * use.face + (use.forward ? 1 : 0); }
    static int turned(const Use& use) { return 2 * use.face + (use.forward ? 0 : 1); }

    geom::DisjointSets sets_;
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

    /// Pairs of edges in one place with two uses each.
    std::vector<EdgePair> find_pairs(double tolerance) {
        TopTools_IndexedMapOfShape vertices;
        for (const PlacedEdge& edge : edges_) TopExp::MapShapes(edge.edge, TopAbs_VERTEX, vertices);
        geom::DisjointSets places = places_of(vertices, tolerance);
        std::multimap<std::array<int, 2>, std::size_t> by_ends;
        std::vector<EdgePair> pairs;
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            const auto [a, b] = ends_of(edges_[i].edge);
            if (a.IsNull() || b.IsNull() || edges_[i].uses.size() != 2) continue;
            std::array<int, 2> ends{places.find(vertices.FindIndex(a) - 1),
                                    places.find(vertices.FindIndex(b) - 1)};
            if (ends[0] > ends[1]) std::swap(ends[0], ends[1]);
            const auto [first, last] = by_ends.equal_range(ends);
            for (auto it = first; it != last && !edges_[i].in_pair; ++it) {
                PlacedEdge& other = edges_[it->second];
                if (other.in_pair) continue;
                const auto reversed = runs_along(other.edge, edges_[i].edge, tolerance);
                if (!reversed) continue;
                other.in_pair = edges_[i].in_pair = true;
                pairs.push_back({it->second, i, *reversed});
            }
            by_ends.emplace(ends, i);
        }
        return pairs;
    }

    /// Where the edges of a pair have vertices of their own in one place: the second's becomes the
    /// first's. False when there are none.
    bool share_vertices(const std::vector<EdgePair>& pairs, BRepTools_ReShape& changes) const {
        bool any = false;
        for (const EdgePair& pair : pairs) {
            const auto kept = ends_of(edges_[pair.first].edge);
            auto other = ends_of(edges_[pair.second].edge);
            if (pair.reversed) std::swap(other[0], other[1]);
            for (const std::size_t end : {0u, 1u}) {
                const TopoDS_Shape to = changes.Value(kept[end].Oriented(TopAbs_FORWARD)),
                                   from = changes.Value(other[end].Oriented(TopAbs_FORWARD));
                if (to.IsSame(from)) continue;
                changes.Replace(from, to);
                any = true;
            }
        }
        return any;
    }

    /// Who shares which edge of each pair. Pairs whose faces hang together elsewhere come first, so
    /// that two parts are joined alike along all the edges where they meet.
    /// @return changes of edges by face; empty where all is well
    std::map<int, std::vector<EdgeChange>> decide(std::vector<EdgePair> pairs) {
        parts_ = OrientedParts(std::size_t(faces_.Extent()));
        for (const PlacedEdge& edge : edges_)
            if (!edge.in_pair && edge.uses.size() == 2) parts_.join(edge.uses[0], edge.uses[1]);
        for (EdgePair& pair : pairs) pair.into = directions_of(pair);
        std::map<int, std::vector<EdgeChange>> changes;
        while (!pairs.empty()) {
            const std::size_t before = pairs.size();
            std::erase_if(pairs, [&](const EdgePair& pair) {
                const auto best = best_joining(pair);
                if (best && best->known == 0) return false;
                if (best) apply(pair, *best, changes);
                return true;
            });
            if (pairs.size() < before) continue;
            apply(pairs.front(), *best_joining(pairs.front()), changes);
            pairs.erase(pairs.begin());
        }
        return changes;
    }

    /// The face with one edge instead of another in the same place.
    static TopoDS_Face exchange(const TopoDS_Face& face, const EdgeChange& change) {
        const auto& [old_edge, new_edge, reversed] = change;
        const TopoDS_Face forward = TopoDS::Face(face.Oriented(TopAbs_FORWARD));
        double first = 0.0, last = 0.0;
        Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(old_edge, forward, first, last);
        if (curve.IsNull()) return face;
        double new_first = 0.0, new_last = 0.0;
        BRep_Tool::Range(new_edge, new_first, new_last);
        curve = over_range(curve, first, last, reversed, new_first, new_last);
        const BRep_Builder builder;
        const double tolerance =
            std::max(BRep_Tool::Tolerance(old_edge), BRep_Tool::Tolerance(new_edge));
        builder.UpdateEdge(new_edge, curve, forward, tolerance);
        builder.Range(new_edge, forward, new_first, new_last);
        BRepTools_ReShape edges;
        edges.Replace(old_edge, reversed ? new_edge.Reversed() : TopoDS_Shape(new_edge));
        return TopoDS::Face(edges.Apply(face));
    }

    /// The model's shape after changes of its parts.
    TopoDS_Shape changed(const TopoDS_Shape& shape, BRepTools_ReShape& changes,
                         FaceOrigins& origins) const {
        TopoDS_Shape result = changes.Apply(shape);
        for (int f = 1; f <= faces_.Extent(); ++f)
            origins.replaced(faces_(f), changes.Value(faces_(f)));
        return result;
    }

    [[nodiscard]] TopoDS_Face face(int number) const { return TopoDS::Face(faces_(number + 1)); }

  private:
    /// The uses of both edges, those of the second as seen along the first.
    [[nodiscard]] std::array<Use, 4> uses_of(const EdgePair& pair) const {
        const PlacedEdge &one = edges_[pair.first], &other = edges_[pair.second];
        std::array<Use, 4> uses{one.uses[0], one.uses[1], other.uses[0], other.uses[1]};
        for (std::size_t i : {2u, 3u}) uses[i].forward = uses[i].forward != pair.reversed;
        return uses;
    }

    /// Of the three ways to join four faces that contradict nothing: the one with the fewest joints
    /// of faces that lie on each other; of these the one with most joints that are known; of these
    /// the one with the narrowest wedges, so that solids that touch stay two; of these the one that
    /// is there. None where all contradict.
    [[nodiscard]] std::optional<Joining> best_joining(const EdgePair& pair) {
        const std::array<Use, 4> uses = uses_of(pair);
        std::optional<Joining> best;
        for (const std::size_t partner : {1u, 2u, 3u}) {
            const std::size_t third = partner == 1 ? 2 : 1, fourth = 6 - partner - third;
            Joining joining{.partner = partner};
            bool contradicts = false;
            for (const auto& [a, b] : {std::pair{std::size_t(0), partner}, {third, fourth}}) {
                const double angle = geom::angle_between(pair.into[a], pair.into[b]);
                contradicts = contradicts || parts_.contradict(uses[a], uses[b]);
                joining.apart += angle > same_angle ? 1 : 0;
                joining.known += parts_.joined(uses[a], uses[b]) ? 1 : 0;
                joining.widest = std::max(joining.widest, angle);
            }
            if (!contradicts && (!best || joining.better_than(*best))) best = joining;
        }
        return best;
    }

    void apply(const EdgePair& pair, const Joining& joining,
               std::map<int, std::vector<EdgeChange>>& changes) {
        const std::array<Use, 4> uses = uses_of(pair);
        const std::size_t third = joining.partner == 1 ? 2 : 1;
        parts_.join(uses[0], uses[joining.partner]);
        parts_.join(uses[third], uses[6 - joining.partner - third]);
        if (joining.partner == 1) return;
        // The partner takes the first edge, and the first edge's other face the second.
        const TopoDS_Edge &one = edges_[pair.first].edge, &other = edges_[pair.second].edge;
        changes[uses[joining.partner].face].push_back({other, one, pair.reversed});
        changes[uses[1].face].push_back({one, other, pair.reversed});
    }

    /// From the middle of the first edge into the faces of both.
    [[nodiscard]] std::array<geom::Vec3, 4> directions_of(const EdgePair& pair) const {
        const PlacedEdge &one = edges_[pair.first], &other = edges_[pair.second];
        double first = 0.0, last = 0.0;
        const Handle(Geom_Curve) curve = BRep_Tool::Curve(one.edge, first, last);
        const double middle = (first + last) / 2;
        const double there =
            Place(other.edge, curve->Value(middle)).parameter.value_or(std::nan(""));
        return {direction_into(one, 0, middle), direction_into(one, 1, middle),
                direction_into(other, 0, there), direction_into(other, 1, there)};
    }

    /// From a point of an edge into a face that uses it, at right angles to it. P-curves are in
    /// step.
    [[nodiscard]] geom::Vec3 direction_into(const PlacedEdge& placed, std::size_t use,
                                            double parameter) const {
        const TopoDS_Face face = this->face(placed.uses[use].face);
        const bool forward = placed.uses[use].forward != (face.Orientation() == TopAbs_REVERSED);
        const TopoDS_Edge edge =
            TopoDS::Edge(placed.edge.Oriented(forward ? TopAbs_FORWARD : TopAbs_REVERSED));
        double first = 0.0, last = 0.0;
        const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(
            edge, TopoDS::Face(face.Oriented(TopAbs_FORWARD)), first, last);
        if (curve.IsNull()) return geom::Vec3::Zero();
        gp_Pnt2d place;
        gp_Vec2d along;
        curve->D1(parameter, place, along);
        gp_Pnt point;
        gp_Vec du, dv;
        BRep_Tool::Surface(face)->D1(place.X(), place.Y(), point, du, dv);
        const geom::Vec3 tangent = vec(along.X() * du + along.Y() * dv);
        return (forward ? 1.0 : -1.0) * vec(du.Crossed(dv)).cross(tangent);
    }

    static std::array<TopoDS_Vertex, 2> ends_of(const TopoDS_Edge& edge) {
        return {TopExp::FirstVertex(edge), TopExp::LastVertex(edge)};
    }

    /// Vertices nearer to each other than the tolerance are in one place.
    static geom::DisjointSets places_of(const TopTools_IndexedMapOfShape& vertices,
                                        double tolerance) {
        std::vector<std::pair<geom::Vec3, int>> sorted;
        for (int i = 1; i <= vertices.Extent(); ++i)
            sorted.emplace_back(vec(BRep_Tool::Pnt(TopoDS::Vertex(vertices(i)))), i - 1);
        std::sort(sorted.begin(), sorted.end(),
                  [](const auto& a, const auto& b) { return a.first.x() < b.first.x(); });
        geom::DisjointSets places(sorted.size());
        for (auto a = sorted.begin(); a != sorted.end(); ++a)
            for (auto b = std::next(a);
                 b != sorted.end() && b->first.x() - a->first.x() <= tolerance; ++b)
                if ((a->first - b->first).norm() <= tolerance) places.join(a->second, b->second);
        return places;
    }

    /// Whether two edges with ends in the same places lie on each other, and then whether the
    /// second runs the other way.
    static std::optional<bool> runs_along(const TopoDS_Edge& a, const TopoDS_Edge& b,
                                          double tolerance) {
        double first = 0, last = 0;
        const Handle(Geom_Curve) curve = BRep_Tool::Curve(a, first, last);
        if (curve.IsNull()) return {};
        std::vector<double> passed;
        for (const double s : {0.25, 0.5, 0.75}) {
            const Place place(b, curve->Value(first + s * (last - first)));
            if (!place.parameter || place.distance > tolerance) return {};
            passed.push_back(*place.parameter);
        }
        return passed.front() > passed.back();
    }

    TopTools_IndexedMapOfShape faces_;
    std::vector<PlacedEdge> edges_;
    OrientedParts parts_;
};

}  // namespace

int pair_coincident_edges(TopoDS_Shape& shape, double tolerance, FaceOrigins& origins) {
    Model model(shape);
    std::vector<EdgePair> pairs = model.find_pairs(tolerance);
    BRepTools_ReShape vertices;
    if (model.share_vertices(pairs, vertices)) {
        shape = model.changed(shape, vertices, origins);
        model = Model(shape);
        pairs = model.find_pairs(tolerance);
    }
    const auto by_face = model.decide(pairs);
    if (by_face.empty()) return 0;
    BRepTools_ReShape faces;
    std::size_t changes = 0;
    for (const auto& [number, edges] : by_face) {
        TopoDS_Face after = model.face(number);
        for (const EdgeChange& change : edges) after = Model::exchange(after, change);
        faces.Replace(model.face(number), after);
        changes += edges.size();
    }
    shape = model.changed(shape, faces, origins);
    return int(changes / 2);
}

}  // namespace patchwright::occ
