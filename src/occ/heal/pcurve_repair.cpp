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
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt2d.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
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
/// Largest deviation by the largest sampled one.
constexpr double sampling_margin = 1.1;

using geom::Vec3;

/// Parameters at which a curve may have kinks, both ends included.
std::vector<double> breaks_of(const Adaptor3d_Curve& curve) {
    TColStd_Array1OfReal at(1, curve.NbIntervals(GeomAbs_C1) + 1);
    curve.Intervals(at, GeomAbs_C1);
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
                  !BRep_Tool::IsClosed(edge, face);
    }
    [[nodiscard]] bool usable() const { return usable_; }

    /// Largest distance of points of equal parameter.
    [[nodiscard]] double deviation(const Handle(Geom2d_Curve) & pcurve) const {
        const int spans = GeomAdaptor_Curve(curve_, first_, last_).NbIntervals(GeomAbs_C1);
        const int samples = std::clamp(5 * spans, 37, 500);
        double worst = 0.0;
        for (int k = 0; k <= samples; ++k) {
            worst = std::max(worst, deviation_at(first_ + (last_ - first_) * k / samples, pcurve));
        }
        return worst;
    }
    [[nodiscard]] double deviation() const { return deviation(pcurve_); }

    /// A polyline in the surface's plane with the edge's parameter; null when it gets too long.
    [[nodiscard]] Handle(Geom2d_Curve) in_step(double tolerance) const {
        const GeomAdaptor_Curve curve(curve_, first_, last_);
        const Adaptor3d_CurveOnSurface image(new Geom2dAdaptor_Curve(pcurve_, first_, last_),
                                             new GeomAdaptor_Surface(surface_));
        const auto curve_breaks = breaks_of(curve), image_breaks = breaks_of(image);
        const Follower on_curve(curve, curve_breaks), on_image(image, image_breaks);
        std::map<double, double> nodes;  // edge's parameter to the p-curve's present one
        const double start = on_curve.parameter_of(vec(image.Value(first_)));
        const bool same = start - first_ < last_ - start;
        // The ends stay where the wire expects them.
        nodes[first_] = same ? first_ : last_;
        nodes[last_] = same ? last_ : first_;
        for (const double s : image_breaks)
            add_node(nodes, on_curve.parameter_of(vec(image.Value(s))), s);
        for (const double t : curve_breaks)
            add_node(nodes, t, on_image.parameter_of(vec(curve.Value(t))));
        return refine(nodes, on_image, tolerance);
    }

  private:
    /// Knots within `same_knot` of each other are one.
    void add_node(std::map<double, double>& nodes, double t, double s) const {
        const double same = same_knot * (last_ - first_);
        const auto next = nodes.lower_bound(t);
        if (next != nodes.end() && next->first - t < same) return;
        if (next != nodes.begin() && t - std::prev(next)->first < same) return;
        nodes.emplace_hint(next, t, s);
    }

    [[nodiscard]] Vec3 on_surface(const gp_Pnt2d& uv) const {
        return vec(surface_->Value(uv.X(), uv.Y()));
    }
    [[nodiscard]] double deviation_at(double t, const Handle(Geom2d_Curve) & pcurve) const {
        return (vec(curve_->Value(t)) - on_surface(pcurve->Value(t))).norm();
    }

    [[nodiscard]] Handle(Geom2d_Curve)
        refine(std::map<double, double>& nodes, const Follower& on_image, double tolerance) const {
        // More than any healthy p-curve has: then the curves differ in space, and the old one
        // stays.
        constexpr std::size_t max_nodes = 4000;
        for (auto here = nodes.begin(); std::next(here) != nodes.end();) {
            const auto next = std::next(here);
            const double t = 0.5 * (here->first + next->first);
            const gp_Pnt2d a = pcurve_->Value(here->second), b = pcurve_->Value(next->second);
            // Not only the middle: there the deviation of an S-shaped stretch is zero.
            double off = 0.0;
            for (const double share : {0.25, 0.5, 0.75}) {
                const double at = here->first + share * (next->first - here->first);
                const gp_Pnt2d uv((1 - share) * a.XY() + share * b.XY());
                off = std::max(off, (vec(curve_->Value(at)) - on_surface(uv)).norm());
            }
            const bool short_enough = next->first - here->first <= same_knot * (last_ - first_);
            if (off <= tolerance || short_enough) {
                ++here;
                continue;
            }
            if (nodes.size() >= max_nodes) return {};
            nodes.emplace(t, on_image.parameter_of(vec(curve_->Value(t))));
        }
        return polyline(nodes);
    }

    [[nodiscard]] Handle(Geom2d_Curve) polyline(const std::map<double, double>& nodes) const {
        const int count = int(nodes.size());
        TColgp_Array1OfPnt2d poles(1, count);
        TColStd_Array1OfReal knots(1, count);
        TColStd_Array1OfInteger multiplicities(1, count);
        multiplicities.Init(1);
        multiplicities(1) = multiplicities(count) = 2;
        int i = 0;
        for (const auto& [t, s] : nodes) {
            knots(++i) = t;
            poles(i) = pcurve_->Value(s);
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
                // Half is no repair: then the curves differ in space, whatever their parameters.
                if (improved < 0.5 * deviation) {
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

}  // namespace patchwright::occ
