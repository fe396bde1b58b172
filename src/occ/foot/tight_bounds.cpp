#include "occ/foot/tight_bounds.h"

#include "occ/foot/trim_region.h"
#include "occ/kernel_points.h"

#include <BRepAdaptor_Curve.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <BndLib_AddSurface.hxx>
#include <Bnd_Box.hxx>
#include <Precision.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace patchwright::occ {

namespace {

using geom::Vec3;

/// One of the six sides of a box, seen as the maximum of a linear function.
struct BoxSide {
    int axis;
    double sign;

    [[nodiscard]] double operator()(const Vec3& p) const { return sign * p[axis]; }
    [[nodiscard]] double of(const geom::Box3& box) const {
        return sign > 0 ? box.max[axis] : -box.min[axis];
    }
};

constexpr BoxSide sides[] = {{0, 1.0}, {0, -1.0}, {1, 1.0}, {1, -1.0}, {2, 1.0}, {2, -1.0}};

int sample_count(int spans, int degree) { return std::clamp(spans * (degree + 1), 12, 200); }

/// Golden section: the sides of an edge's box lie at its ends or where it turns.
void add_turning_point(const BRepAdaptor_Curve& curve, double low, double high, const BoxSide& side,
                       geom::Box3& box) {
    constexpr double golden = 0.6180339887498949;
    for (int i = 0; i < 40; ++i) {
        const double a = high - golden * (high - low), b = low + golden * (high - low);
        if (side(vec(curve.Value(a))) < side(vec(curve.Value(b)))) {
            low = a;
        } else {
            high = b;
        }
    }
    box.add(vec(curve.Value(0.5 * (low + high))));
}

void add_edge(const TopoDS_Edge& edge, geom::Box3& box) {
    if (BRep_Tool::Degenerated(edge)) return;
    const BRepAdaptor_Curve curve(edge);
    const double first = curve.FirstParameter(), last = curve.LastParameter();
    if (Precision::IsInfinite(first) || Precision::IsInfinite(last)) return;
    const bool line = curve.GetType() == GeomAbs_Line;
    const bool spline = curve.GetType() == GeomAbs_BSplineCurve;
    const int count = line ? 1 : sample_count(spline ? curve.NbKnots() - 1 : 2, 3);
    const auto parameter = [&](int k) { return first + (last - first) * k / count; };
    std::vector<Vec3> points;
    double reach = 0.0;
    for (int k = 0; k <= count; ++k) {
        points.push_back(vec(curve.Value(parameter(k))));
        box.add(points.back());
        if (k > 0)
            reach = std::max(reach, (points[std::size_t(k)] - points[std::size_t(k) - 1]).norm());
    }
    if (line) return;
    for (const BoxSide& side : sides) {
        const auto best =
            std::max_element(points.begin(), points.end(),
                             [&](const Vec3& a, const Vec3& b) { return side(a) < side(b); });
        if (side(*best) + reach <= side.of(box)) continue;
        const int k = int(best - points.begin());
        add_turning_point(curve, parameter(std::max(k - 1, 0)), parameter(std::min(k + 1, count)),
                          side, box);
    }
}

/// Where a face bulges beyond its edges.
class FaceBulge {
  public:
    explicit FaceBulge(const TopoDS_Face& face) : face_(face), surface_(face, false) {
        BRepTools::UVBounds(face, low_[0], high_[0], low_[1], high_[1]);
    }

    void add_to(geom::Box3& box) {
        if (surface_.GetType() == GeomAbs_Plane || !bounded() || !may_leave(box)) return;
        take_samples();
        for (const BoxSide& side : sides) climb(side, box);
    }

  private:
    struct BoundSample {
        Vec2 uv;
        Vec3 point;
    };

    [[nodiscard]] bool bounded() const {
        return low_.allFinite() && high_.allFinite() && low_.cwiseAbs().maxCoeff() < 1e99 &&
               high_.cwiseAbs().maxCoeff() < 1e99;
    }

    /// By the box of the control points, which is quick.
    [[nodiscard]] bool may_leave(const geom::Box3& box) const {
        Bnd_Box hull;
        BndLib_AddSurface::Add(surface_, low_[0], high_[0], low_[1], high_[1], 0.0, hull);
        if (hull.IsVoid()) return true;
        hull.SetGap(0.0);
        const double slack = 1e-9 * box.diagonal();
        return hull.IsOpen() || box.empty() ||
               (vec(hull.CornerMin()).array() < box.min.array() - slack).any() ||
               (vec(hull.CornerMax()).array() > box.max.array() + slack).any();
    }

    [[nodiscard]] Vec3 at(const Vec2& uv) const { return vec(surface_.Value(uv[0], uv[1])); }

    void take_samples() {
        const bool spline = surface_.GetType() == GeomAbs_BSplineSurface;
        const int nu = sample_count(spline ? surface_.NbUKnots() - 1 : 4, 1);
        const int nv = sample_count(spline ? surface_.NbVKnots() - 1 : 4, 1);
        step_ = (high_ - low_).cwiseQuotient(Vec2(nu, nv));
        for (int i = 0; i <= nu; ++i) {
            for (int j = 0; j <= nv; ++j) {
                const Vec2 uv = low_ + step_.cwiseProduct(Vec2(i, j));
                samples_.push_back({uv, at(uv)});
                if (j > 0) reach_ = std::max(reach_, distance(samples_.size() - 2));
                if (i > 0)
                    reach_ = std::max(reach_, distance(samples_.size() - 2 - std::size_t(nv)));
            }
        }
    }

    [[nodiscard]] double distance(std::size_t to) const {
        return (samples_.back().point - samples_[to].point).norm();
    }

    [[nodiscard]] bool inside(const Vec2& uv) {
        if (!trim_) trim_.emplace(face_);
        return trim_->contains(uv);
    }

    /// From the best samples that belong to the face, by steps that shrink.
    void climb(const BoxSide& side, geom::Box3& box) {
        std::vector<const BoundSample*> order;
        for (const BoundSample& s : samples_) {
            if (side(s.point) + reach_ > side.of(box)) order.push_back(&s);
        }
        constexpr std::size_t max_tried = 64;
        const auto kept = std::min(order.size(), max_tried);
        std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(kept), order.end(),
                          [&](const BoundSample* a, const BoundSample* b) {
                              return side(a->point) > side(b->point);
                          });
        order.resize(kept);
        int climbed = 0;
        for (const BoundSample* s : order) {
            if (climbed == 3 || side(s->point) + reach_ <= side.of(box)) break;
            if (!inside(s->uv)) continue;
            box.add(climb_from(*s, side));
            ++climbed;
        }
    }

    Vec3 climb_from(BoundSample best, const BoxSide& side) {
        Vec2 step = 0.5 * step_;
        for (int halvings = 0; halvings < 24;) {
            bool moved = false;
            for (const Vec2& way : {Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)}) {
                const Vec2 uv = (best.uv + step.cwiseProduct(way)).cwiseMax(low_).cwiseMin(high_);
                const Vec3 point = at(uv);
                if (!(side(point) > side(best.point)) || !inside(uv)) continue;
                best = {uv, point};
                moved = true;
            }
            if (moved) continue;
            step *= 0.5;
            ++halvings;
        }
        return best.point;
    }

    TopoDS_Face face_;
    BRepAdaptor_Surface surface_;
    Vec2 low_, high_, step_;
    std::vector<BoundSample> samples_;
    double reach_ = 0.0;
    std::optional<TrimRegion> trim_;
};

}  // namespace

geom::Box3 tight_bounds(const TopoDS_Shape& shape) {
    geom::Box3 box;
    TopTools_IndexedMapOfShape edges, faces;
    TopExp::MapShapes(shape, TopAbs_EDGE, edges);
    TopExp::MapShapes(shape, TopAbs_FACE, faces);
    for (int i = 1; i <= edges.Extent(); ++i) add_edge(TopoDS::Edge(edges(i)), box);
    for (int i = 1; i <= faces.Extent(); ++i) FaceBulge(TopoDS::Face(faces(i))).add_to(box);
    return box;
}

}  // namespace patchwright::occ
