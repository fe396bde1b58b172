#include "occ/heal/pcurve_repair.h"

#include "occ/kernel_points.h"

#include <Adaptor3d_CurveOnSurface.hxx>
#include <BRep_Builder.hxx>
#include <BRep_TEdge.hxx>
#include <BRep_TVertex.hxx>
#include <BRep_Tool.hxx>
#include <Geom2dAdaptor_Curve.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <Precision.hxx>
#include <ShapeAnalysis_Surface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt2d.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Vertex.hxx>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace patchwright::occ {

namespace {

/// Of an edge's range: knots nearer to each other than this are one.
constexpr double same_knot = 1e-6;
/// What a new p-curve aims at, of the tolerance: it has to pass the same check later.
constexpr double target_share = 0.1;
/// Of what it was: a p-curve that leaves more deviation is no repair.
constexpr double sufficient_share = 0.5;
/// Largest deviation by an edge's tolerance, which writers measure in a few points.
constexpr double declared_margin = 2.0;
/// Largest deviation by the largest sampled one.
constexpr double sampling_margin = 1.1;

using geom::Vec3;

/// Parameters at which a curve, in space or in a plane, may not be as smooth; both ends included.
template <class Curve>
std::vector<double> breaks_of(const Curve& curve, GeomAbs_Shape smoothness = GeomAbs_C1) {
    TColStd_Array1OfReal at(1, curve.NbIntervals(smoothness) + 1);
    curve.Intervals(at, smoothness);
    return {at.begin(), at.end()};
}

/// Nearest points of a curve for queries that advance along it.
class Follower {
  public:
    Follower(const Adaptor3d_Curve& curve, const std::vector<double>& breaks) : curve_(curve) {
        constexpr int samples_per_interval = 32;
        for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
            for (int k = 0; k < samples_per_interval; ++k) {
                const double share = double(k) / samples_per_interval;
                parameters_.push_back(breaks[i] + share * (breaks[i + 1] - breaks[i]));
            }
        }
        parameters_.push_back(breaks.back());
        for (const double t : parameters_) points_.push_back(vec(curve.Value(t)));
    }

    [[nodiscard]] double parameter_of(const Vec3& query) const {
        const auto distance = [&](const Vec3& p) { return (p - query).squaredNorm(); };
        const auto nearest = std::min_element(
            points_.begin(), points_.end(),
            [&](const Vec3& a, const Vec3& b) { return distance(a) < distance(b); });
        const auto k = std::size_t(nearest - points_.begin());
        double best = parameters_[k], best_distance = distance(*nearest);
        // Either side of the sample by itself: there may be a kink at it.
        for (const auto& [i, j] : {std::pair{k == 0 ? k : k - 1, k},
                                   std::pair{k, std::min(k + 1, points_.size() - 1)}}) {
            if (i == j) continue;
            const double t = newton(query, parameters_[i], parameters_[j]);
            const double d = distance(vec(curve_.Value(t)));
            if (d < best_distance) {
                best = t;
                best_distance = d;
            }
        }
        return best;
    }

  private:
    [[nodiscard]] double newton(const Vec3& query, double low, double high) const {
        double t = 0.5 * (low + high);
        for (int i = 0; i < 20; ++i) {
            gp_Pnt p;
            gp_Vec d;
            curve_.D1(t, p, d);
            const double next = std::clamp(
                t + vec(d).dot(query - vec(p)) / std::max(vec(d).squaredNorm(), 1e-300), low, high);
            if (std::abs(next - t) <= 1e-15 * (std::abs(low) + std::abs(high))) break;
            t = next;
        }
        return t;
    }

    const Adaptor3d_Curve& curve_;
    std::vector<double> parameters_;
    std::vector<Vec3> points_;
};

/// An edge's curve and its image on one of its faces.
class Track {
  public:
    Track(const TopoDS_Edge& edge, const TopoDS_Face& face) {
        curve_ = BRep_Tool::Curve(edge, first_, last_);
        double first = 0, last = 0;
        pcurve_ = BRep_Tool::CurveOnSurface(edge, face, first, last);
        surface_ = BRep_Tool::Surface(face);
        usable_ = !curve_.IsNull() && !pcurve_.IsNull() && first == first_ && last == last_ &&
                  first_ < last_ && !BRep_Tool::IsClosed(edge, face);
    }
    [[nodiscard]] bool usable() const { return usable_; }

    /// Largest distance of points of equal parameter, looked for in every span of both curves.
    [[nodiscard]] double deviation(const Handle(Geom2d_Curve) & pcurve) const {
        constexpr int least_samples = 37, samples_a_span = 5;
        const GeomAdaptor_Curve curve(curve_, first_, last_);
        const Geom2dAdaptor_Curve flat(pcurve, first_, last_);
        const GeomAdaptor_Surface surface(surface_);
        std::vector<double> spans = breaks_of(curve, GeomAbs_CN);
        const std::vector<double> of_pcurve = breaks_of(flat, GeomAbs_CN);
        spans.insert(spans.end(), of_pcurve.begin(), of_pcurve.end());
        std::sort(spans.begin(), spans.end());
        spans.erase(std::unique(spans.begin(), spans.end()), spans.end());
        const int samples = std::max(samples_a_span, least_samples / int(spans.size() - 1));
        double worst = 0.0;
        const auto look_at = [&](double t) {
            const gp_Pnt2d uv = flat.Value(t);
            worst = std::max(worst, curve.Value(t).Distance(surface.Value(uv.X(), uv.Y())));
        };
        for (std::size_t i = 0; i + 1 < spans.size(); ++i)
            for (int k = 0; k < samples; ++k)
                look_at(spans[i] + (spans[i + 1] - spans[i]) * k / samples);
        look_at(last_);
        return worst;
    }
    [[nodiscard]] double deviation() const { return deviation(pcurve_); }

    /// The p-curve as it runs, with the edge's parameter: a polyline; null when it gets too long.
    [[nodiscard]] Handle(Geom2d_Curve) in_step(double tolerance) const {
        const GeomAdaptor_Curve curve(curve_, first_, last_);
        const Adaptor3d_CurveOnSurface image(new Geom2dAdaptor_Curve(pcurve_, first_, last_),
                                             new GeomAdaptor_Surface(surface_));
        const auto curve_breaks = breaks_of(curve), image_breaks = breaks_of(image);
        const Follower on_curve(curve, curve_breaks), on_image(image, image_breaks);
        const double start = on_curve.parameter_of(vec(image.Value(first_)));
        const bool same = start - first_ < last_ - start;
        // The ends stay where the wire expects them.
        Nodes nodes{{first_, pcurve_->Value(same ? first_ : last_)},
                    {last_, pcurve_->Value(same ? last_ : first_)}};
        for (const double s : image_breaks)
            add_node(nodes, on_curve.parameter_of(vec(image.Value(s))), pcurve_->Value(s));
        const auto place = [&](double t) {
            return pcurve_->Value(on_image.parameter_of(vec(curve.Value(t))));
        };
        for (const double t : curve_breaks) add_node(nodes, t, place(t));
        const auto aim = [&](double t) { return vec(curve.Value(t)); };
        return refine(nodes, place, aim, tolerance);
    }

    /// The edge's curve, projected onto the surface: a polyline; null when it gets too long, or
    /// where the curve is farther than `most` from the surface.
    [[nodiscard]] Handle(Geom2d_Curve) onto_edge(double tolerance, double most) const {
        ShapeAnalysis_Surface surface(surface_);
        const auto place = [&](double t) {
            const gp_Pnt2d near = pcurve_->Value(t);
            gp_Pnt2d uv = surface.NextValueOfUV(near, curve_->Value(t), Precision::Confusion());
            if (surface_->IsUPeriodic()) uv.SetX(beside(near.X(), uv.X(), surface_->UPeriod()));
            if (surface_->IsVPeriodic()) uv.SetY(beside(near.Y(), uv.Y(), surface_->VPeriod()));
            return uv;
        };
        const auto aim = [&](double t) { return on_surface(place(t)); };
        constexpr int checks = 16;
        for (int k = 0; k <= checks; ++k) {
            const double t = first_ + (last_ - first_) * k / checks;
            if (!((vec(curve_->Value(t)) - aim(t)).norm() <= most)) return {};
        }
        // The ends stay where the wire expects them.
        Nodes nodes{{first_, pcurve_->Value(first_)}, {last_, pcurve_->Value(last_)}};
        for (const double t : breaks_of(GeomAdaptor_Curve(curve_, first_, last_)))
            add_node(nodes, t, place(t));
        return refine(nodes, place, aim, tolerance);
    }

  private:
    using Nodes = std::map<double, gp_Pnt2d>;  ///< of a p-curve, by the edge's parameter

    /// `x` plus whole periods, at most half a period from `near`.
    [[nodiscard]] static double beside(double near, double x, double period) {
        return x + period * std::round((near - x) / period);
    }

    /// Knots within `same_knot` of each other are one.
    void add_node(Nodes& nodes, double t, const gp_Pnt2d& uv) const {
        const double same = same_knot * (last_ - first_);
        const auto next = nodes.lower_bound(t);
        if (next != nodes.end() && next->first - t < same) return;
        if (next != nodes.begin() && t - std::prev(next)->first < same) return;
        nodes.emplace_hint(next, t, uv);
    }

    [[nodiscard]] Vec3 on_surface(const gp_Pnt2d& uv) const {
        return vec(surface_->Value(uv.X(), uv.Y()));
    }

    /// @param place  where the new p-curve is at a parameter of the edge
    /// @param aim    what its image is to be near there
    template <class Place, class Aim>
    [[nodiscard]] Handle(Geom2d_Curve)
        refine(Nodes& nodes, const Place& place, const Aim& aim, double tolerance) const {
        // More than any healthy p-curve has: then the curves differ in space, and the old one
        // stays.
        constexpr std::size_t max_nodes = 4000;
        for (auto here = nodes.begin(); std::next(here) != nodes.end();) {
            const auto next = std::next(here);
            const double t = 0.5 * (here->first + next->first);
            // Not only the middle: there the deviation of an S-shaped stretch is zero.
            double off = 0.0;
            for (const double share : {0.25, 0.5, 0.75}) {
                const double at = here->first + share * (next->first - here->first);
                const gp_Pnt2d uv((1 - share) * here->second.XY() + share * next->second.XY());
                off = std::max(off, (aim(at) - on_surface(uv)).norm());
            }
            const bool short_enough = next->first - here->first <= same_knot * (last_ - first_);
            if (off <= tolerance || short_enough) {
                ++here;
                continue;
            }
            if (nodes.size() >= max_nodes) return {};
            nodes.emplace(t, place(t));
        }
        return polyline(nodes);
    }

    [[nodiscard]] static Handle(Geom2d_Curve) polyline(const Nodes& nodes) {
        const int count = int(nodes.size());
        TColgp_Array1OfPnt2d poles(1, count);
        TColStd_Array1OfReal knots(1, count);
        TColStd_Array1OfInteger multiplicities(1, count);
        multiplicities.Init(1);
        multiplicities(1) = multiplicities(count) = 2;
        int i = 0;
        for (const auto& [t, uv] : nodes) {
            knots(++i) = t;
            poles(i) = uv;
        }
        return new Geom2d_BSplineCurve(poles, knots, multiplicities, 1);
    }

    Handle(Geom_Curve) curve_;
    Handle(Geom2d_Curve) pcurve_;
    Handle(Geom_Surface) surface_;
    double first_ = 0.0, last_ = 0.0;
    bool usable_ = false;
};

/// The builder only ever raises tolerances.
void set_tolerance(const TopoDS_Edge& edge, double tolerance) {
    Handle(BRep_TEdge)::DownCast(edge.TShape())->Tolerance(tolerance);
}

void fit_vertex_tolerances(const TopoDS_Shape& shape, const TopTools_IndexedMapOfShape& touched) {
    TopTools_IndexedDataMapOfShapeListOfShape edges;
    TopExp::MapShapesAndAncestors(shape, TopAbs_VERTEX, TopAbs_EDGE, edges);
    for (int i = 1; i <= touched.Extent(); ++i) {
        const TopoDS_Vertex vertex = TopoDS::Vertex(touched(i));
        const gp_Pnt at = BRep_Tool::Pnt(vertex);
        double tolerance = Precision::Confusion();
        for (const TopoDS_Shape& shape_of_edge : edges.FindFromKey(vertex)) {
            const TopoDS_Edge& edge = TopoDS::Edge(shape_of_edge);
            tolerance = std::max(tolerance, BRep_Tool::Tolerance(edge));
            double first = 0, last = 0;
            const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
            if (curve.IsNull()) continue;
            const double t = BRep_Tool::Parameter(vertex, edge);
            tolerance = std::max(tolerance, at.Distance(curve->Value(t)));
        }
        Handle(BRep_TVertex)::DownCast(vertex.TShape())->Tolerance(tolerance);
    }
}

}  // namespace

int bring_pcurves_into_step(const TopoDS_Shape& shape, double tolerance) {
    TopTools_IndexedDataMapOfShapeListOfShape faces;
    TopExp::MapShapesAndAncestors(shape, TopAbs_EDGE, TopAbs_FACE, faces);
    TopTools_IndexedMapOfShape touched;
    const BRep_Builder builder;
    int replaced = 0;
    for (int i = 1; i <= faces.Extent(); ++i) {
        const TopoDS_Edge edge = TopoDS::Edge(faces.FindKey(i));
        if (BRep_Tool::Degenerated(edge)) continue;
        const int before = replaced;
        double worst = Precision::Confusion();
        bool all_known = true;
        for (const TopoDS_Shape& face : faces(i)) {
            const Track track(edge, TopoDS::Face(face));
            all_known = all_known && track.usable();
            if (!track.usable()) continue;
            double deviation = track.deviation();
            if (deviation > tolerance) {
                const Handle(Geom2d_Curve) pcurve = track.in_step(target_share * tolerance);
                const double improved = pcurve.IsNull() ? deviation : track.deviation(pcurve);
                // Else the curves differ in space, whatever their parameters.
                if (improved < sufficient_share * deviation) {
                    builder.UpdateEdge(edge, pcurve, TopoDS::Face(face), Precision::Confusion());
                    deviation = improved;
                    ++replaced;
                }
            }
            worst = std::max(worst, deviation);
        }
        // The kernel's own tolerance may be too small as well.
        if (worst > BRep_Tool::Tolerance(edge)) builder.UpdateEdge(edge, worst);
        if (replaced == before || !all_known) continue;
        // Between samples it may be a little more.
        set_tolerance(edge, std::max(sampling_margin * worst, Precision::Confusion()));
        TopExp::MapShapes(edge, TopAbs_VERTEX, touched);
    }
    fit_vertex_tolerances(shape, touched);
    return replaced;
}

int bring_pcurves_onto_edges(const TopoDS_Shape& shape, double tolerance) {
    TopTools_IndexedDataMapOfShapeListOfShape faces;
    TopExp::MapShapesAndAncestors(shape, TopAbs_EDGE, TopAbs_FACE, faces);
    const BRep_Builder builder;
    int replaced = 0;
    for (int i = 1; i <= faces.Extent(); ++i) {
        const TopoDS_Edge edge = TopoDS::Edge(faces.FindKey(i));
        if (BRep_Tool::Degenerated(edge)) continue;
        const double allowed = std::max(tolerance, declared_margin * BRep_Tool::Tolerance(edge));
        for (const TopoDS_Shape& face : faces(i)) {
            const Track track(edge, TopoDS::Face(face));
            if (!track.usable()) continue;
            const double deviation = track.deviation();
            if (!(deviation > allowed) || !std::isfinite(deviation)) continue;
            const double sufficient = sufficient_share * deviation;
            const Handle(Geom2d_Curve) pcurve = track.onto_edge(target_share * allowed, sufficient);
            if (pcurve.IsNull()) continue;
            const double improved = track.deviation(pcurve);
            if (improved > sufficient) continue;
            builder.UpdateEdge(edge, pcurve, TopoDS::Face(face), sampling_margin * improved);
            for (TopoDS_Iterator v(edge); v.More(); v.Next())
                builder.UpdateVertex(TopoDS::Vertex(v.Value()), BRep_Tool::Tolerance(edge));
            ++replaced;
        }
    }
    return replaced;
}

}  // namespace patchwright::occ
