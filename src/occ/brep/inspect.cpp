#include "occ/brep/mass.h"
#include "occ/exchange/cad_model_impl.h"
#include "occ/foot/tight_bounds.h"
#include "occ/kernel_guard.h"
#include "occ/kernel_points.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/inspect.h>

#include <BRepAdaptor_Surface.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <ShapeAnalysis_ShapeTolerance.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace patchwright::occ {

namespace {

std::string kind_of(const TopoDS_Face& face) {
    const BRepAdaptor_Surface surface(face, false);
    switch (surface.GetType()) {
        case GeomAbs_Plane: return "plane";
        case GeomAbs_Cylinder: return "cylinder";
        case GeomAbs_Cone: return "cone";
        case GeomAbs_Sphere: return "sphere";
        case GeomAbs_Torus: return "torus";
        case GeomAbs_SurfaceOfRevolution: return "revolution";
        case GeomAbs_SurfaceOfExtrusion: return "extrusion";
        case GeomAbs_OffsetSurface: return "offset";
        case GeomAbs_BezierSurface:
        case GeomAbs_BSplineSurface: {
            const bool rational = surface.IsURational() || surface.IsVRational();
            return fmt::format("{} {}x{}{}",
                               surface.GetType() == GeomAbs_BezierSurface ? "bezier" : "bspline",
                               surface.UDegree(), surface.VDegree(), rational ? " rational" : "");
        }
        default: return "other";
    }
}

void count_edges(const TopoDS_Shape& shape, Inspection& result) {
    const std::vector<int> uses = edge_uses(shape);
    result.edges = static_cast<int>(uses.size());
    result.free_edges = static_cast<int>(std::count(uses.begin(), uses.end(), 1));
    result.nonmanifold_edges =
        static_cast<int>(std::count_if(uses.begin(), uses.end(), [](int n) { return n > 2; }));
    result.closed = result.faces > 0 && result.free_edges == 0 && result.nonmanifold_edges == 0;
}

int count(const TopoDS_Shape& shape, TopAbs_ShapeEnum what) {
    TopTools_IndexedMapOfShape map;
    TopExp::MapShapes(shape, what, map);
    return map.Extent();
}

Inspection inspect_shape(const CadModel& model) {
    const TopoDS_Shape& shape = model.impl().shape;
    Inspection result;
    result.solids = count(shape, TopAbs_SOLID);
    result.vertices = count(shape, TopAbs_VERTEX);
    for (TopExp_Explorer it(shape, TopAbs_SHELL); it.More(); it.Next()) {
        (BRep_Tool::IsClosed(it.Current()) ? result.shells_closed : result.shells_open) += 1;
    }
    result.all_bicubic = true;
    for (const TopoDS_Face& face : faces_of(model)) {
        ++result.faces;
        ++result.faces_by_kind[kind_of(face)];
        result.all_bicubic = result.all_bicubic && !whole_bicubic(face).IsNull();
    }
    result.all_bicubic = result.all_bicubic && result.faces > 0;
    count_edges(shape, result);

    result.bounds = tight_bounds(shape);
    const Mass mass = measure_mass(shape);
    result.area_mm2 = mass.area_mm2;
    result.volume_mm3 = mass.volume_mm3;
    result.max_tolerance_mm = ShapeAnalysis_ShapeTolerance().Tolerance(shape, 1);
    result.valid = BRepCheck_Analyzer(shape).IsValid();
    return result;
}

/// Points in cells of a grid, so that looking one up does not look at all.
class PointGrid {
  public:
    PointGrid(const geom::Points& points, double reach) : points_(points), reach_(reach) {
        for (Eigen::Index i = 0; i < points.rows(); ++i)
            cells_.emplace(key(cell(points.row(i))), i);
    }
    [[nodiscard]] bool has_near(const geom::Vec3& p) const {
        const auto at = cell(p.transpose());
        for (int k = 0; k < 27; ++k) {
            const auto [first, last] = cells_.equal_range(
                key({at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1}));
            for (auto it = first; it != last; ++it) {
                if ((points_.row(it->second).transpose() - p).norm() <= reach_) return true;
            }
        }
        return false;
    }

  private:
    using Cell = std::array<std::int64_t, 3>;
    [[nodiscard]] Cell cell(const Eigen::RowVector3d& p) const {
        return {std::llround(p.x() / reach_), std::llround(p.y() / reach_),
                std::llround(p.z() / reach_)};
    }
    static std::uint64_t key(const Cell& c) {
        return std::uint64_t(c[0]) * 0x9E3779B97F4A7C15u ^
               std::uint64_t(c[1]) * 0xC2B2AE3D27D4EB4Fu ^
               std::uint64_t(c[2]) * 0x165667B19E3779F9u;
    }
    const geom::Points& points_;
    double reach_;
    std::unordered_multimap<std::uint64_t, Eigen::Index> cells_;
};

/// One face's view of an edge.
struct EdgeSide {
    TopoDS_Face face;
    TopoDS_Edge edge;
};

/// Evaluates a face along one of its edges.
class SideProbe {
  public:
    explicit SideProbe(const EdgeSide& side)
        : surface_(side.face, false), reversed_(side.face.Orientation() == TopAbs_REVERSED) {
        curve_ = BRep_Tool::CurveOnSurface(side.edge, side.face, first_, last_);
    }
    [[nodiscard]] bool usable() const { return !curve_.IsNull(); }
    /// @param share  of the edge's range, 0 to 1
    void at(double share, geom::Vec3& point, geom::Vec3& normal) const {
        const gp_Pnt2d uv = curve_->Value(first_ + share * (last_ - first_));
        gp_Pnt p;
        gp_Vec du, dv;
        surface_.D1(uv.X(), uv.Y(), p, du, dv);
        point = vec(p);
        const gp_Vec n = du.Crossed(dv);
        const double size = n.Magnitude();
        normal = size > 1e-12 * du.Magnitude() * dv.Magnitude() && size > 0.0
                     ? geom::Vec3(vec(n) / (reversed_ ? -size : size))
                     : geom::Vec3::Zero();
    }

  private:
    BRepAdaptor_Surface surface_;
    bool reversed_;
    Handle(Geom2d_Curve) curve_;
    double first_ = 0.0;
    double last_ = 0.0;
};

/// The angle between unit vectors, accurate for small ones too.
double angle(const geom::Vec3& a, const geom::Vec3& b) {
    return 2.0 * std::atan2((a - b).norm(), (a + b).norm());
}

/// Measures along edges into one result.
class EdgeKinks {
  public:
    EdgeKinks(const ContinuityOptions& options, patch::Continuity& result)
        : singular_(options.singular_points, std::max(options.singular_distance_mm, 1e-12)),
          has_singular_(options.singular_points.rows() > 0 && options.singular_distance_mm > 0.0),
          samples_(options.samples_per_edge),
          result_(result) {}

    void measure(const EdgeSide& a, const EdgeSide& b, bool crease) const {
        const SideProbe left(a);
        const SideProbe right(b);
        if (!left.usable() || !right.usable()) return;
        double before = 0.0;
        bool was_near = false;
        for (int k = 0; k < samples_; ++k) {
            const double share = double(k) / (samples_ - 1);
            const bool is_near = sample(left, right, crease, share);
            if (k > 0 && is_near != was_near && !crease) {
                const double inside = is_near ? share : before, outside = is_near ? before : share;
                const double border = border_between(left, inside, outside);
                // Kinks at a singular vertex fade with the distance from it.
                for (double part = 1.0; part > 1e-3; part *= 0.5) {
                    sample(left, right, crease, border + part * (outside - border));
                    sample(left, right, crease, border + part * (inside - border));
                }
            }
            before = share;
            was_near = is_near;
        }
    }

  private:
    /// Whether it is near a singular vertex.
    bool sample(const SideProbe& left, const SideProbe& right, bool crease, double share) const {
        geom::Vec3 p, q, n, m;
        left.at(share, p, n);
        right.at(share, q, m);
        if ((p - q).norm() > result_.max_gap_mm) {
            result_.max_gap_mm = (p - q).norm();
            result_.gap_at = p;
        }
        const bool is_near = has_singular_ && singular_.has_near(p);
        if (crease || n.isZero() || m.isZero()) return is_near;
        double& largest = is_near ? result_.near_singular_kink_rad : result_.max_kink_rad;
        if (const double kink = angle(n, m); kink > largest) {
            largest = kink;
            (is_near ? result_.near_singular_kink_at : result_.kink_at) = p;
        }
        return is_near;
    }

    /// Outside, and as near to the neighbourhood as halving comes.
    [[nodiscard]] double border_between(const SideProbe& side, double inside,
                                        double outside) const {
        constexpr int halvings = 30;
        geom::Vec3 p, n;
        for (int k = 0; k < halvings; ++k) {
            const double middle = 0.5 * (inside + outside);
            side.at(middle, p, n);
            (singular_.has_near(p) ? inside : outside) = middle;
        }
        return outside;
    }

    PointGrid singular_;
    bool has_singular_;
    int samples_;
    patch::Continuity& result_;
};

}  // namespace

Inspection inspect(const CadModel& model) {
    return guard_kernel<base::InputError>("inspecting the model",
                                          [&] { return inspect_shape(model); });
}

patch::Continuity measure_continuity(const CadModel& model, const geom::Points& crease_points,
                                     const ContinuityOptions& options) {
    if (options.samples_per_edge < 2)
        throw base::InvalidArgument("continuity needs at least 2 samples an edge");
    return guard_kernel<base::InputError>("measuring continuity", [&] {
        TopTools_IndexedMapOfShape edges;
        std::vector<std::vector<EdgeSide>> sides;
        geom::Box3 box;
        for (const TopoDS_Face& face : faces_of(model)) {
            for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
                const TopoDS_Edge& edge = TopoDS::Edge(it.Current());
                if (BRep_Tool::Degenerated(edge)) continue;
                const auto number = std::size_t(edges.Add(edge));
                if (number > sides.size()) sides.emplace_back();
                sides[number - 1].push_back({face, edge});
            }
        }
        for (TopExp_Explorer it(model.impl().shape, TopAbs_VERTEX); it.More(); it.Next()) {
            box.add(vec(BRep_Tool::Pnt(TopoDS::Vertex(it.Current()))));
        }
        const PointGrid creases(crease_points, std::max(1e-6 * box.diagonal(), 1e-12));
        patch::Continuity result;
        const EdgeKinks edge_measure(options, result);
        for (const auto& pair : sides) {
            if (pair.size() != 2) continue;
            double first = 0, last = 0;
            const Handle(Geom_Curve) curve = BRep_Tool::Curve(pair[0].edge, first, last);
            const bool crease =
                !curve.IsNull() && creases.has_near(vec(curve->Value(0.5 * (first + last))));
            (crease ? result.crease_edges : result.smooth_edges) += 1;
            edge_measure.measure(pair[0], pair[1], crease);
        }
        return result;
    });
}

}  // namespace patchwright::occ
