#include "occ/foot/kernel_extrema.h"

#include "occ/kernel_points.h"

#include <BRepAdaptor_Surface.hxx>
#include <BRep_Tool.hxx>
#include <BndLib_Add3dCurve.hxx>
#include <BndLib_AddSurface.hxx>
#include <Bnd_Box.hxx>
#include <Extrema_ExtPC.hxx>
#include <Extrema_ExtPS.hxx>
#include <Extrema_GenExtPS.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <Precision.hxx>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

namespace patchwright::occ {

namespace {

using geom::Vec3;

/// Of parameters: as fine as the kernel's own searches.
constexpr double parameter_tolerance = 1e-10;
/// Starts in each direction of a piece without knots inside.
constexpr int starts = 12;
/// Of a piece's extent: how far it reaches into its neighbours, so that a minimum on the line
/// between them is within both.
constexpr double overlap = 1e-3;

gp_Pnt kernel_point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

Bnd_Box curve_box(const GeomAdaptor_Curve& curve) {
    Bnd_Box box;
    BndLib_Add3dCurve::Add(curve, curve.FirstParameter(), curve.LastParameter(),
                           Precision::Confusion(), box);
    return box;
}

/// A part of a face within which its surface is smooth: over knots the kernel's steps go astray.
struct Piece {
    std::size_t face;
    FaceSurface::Rectangle range;
    bool closed_form;  ///< plane, cylinder, cone, sphere, torus: the whole face
    Bnd_Box box;
};

bool has_closed_form(GeomAbs_SurfaceType type) {
    return type == GeomAbs_Plane || type == GeomAbs_Cylinder || type == GeomAbs_Cone ||
           type == GeomAbs_Sphere || type == GeomAbs_Torus;
}

std::vector<Piece> pieces_of(const std::vector<TopoDS_Face>& faces,
                             const std::vector<FaceSurface>& surfaces) {
    std::vector<Piece> pieces;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (surfaces[f].unbounded()) continue;
        const BRepAdaptor_Surface adaptor(faces[f], Standard_False);
        const FaceSurface::Rectangle whole{surfaces[f].low(), surfaces[f].high()};
        const auto add = [&](const FaceSurface::Rectangle& range, bool closed_form) {
            Piece piece{f, range, closed_form, {}};
            BndLib_AddSurface::Add(adaptor, range.low[0], range.high[0], range.low[1],
                                   range.high[1], Precision::Confusion(), piece.box);
            pieces.push_back(piece);
        };
        if (has_closed_form(adaptor.GetType())) {
            add(whole, true);
            continue;
        }
        surfaces[f].each_span(whole, [&](const FaceSurface::Rectangle& span) {
            const Vec2 margin = overlap * (span.high - span.low);
            add({(span.low - margin).cwiseMax(whole.low),
                 (span.high + margin).cwiseMin(whole.high)},
                false);
        });
    }
    return pieces;
}

/// A side of the rectangle around a face, as a curve on its surface: where it ends without a trim
/// its edge may lie off it.
struct SideTool {
    /// @param axis  parameter that is fixed: 0 is u
    SideTool(const Handle(Geom_Surface) & surface, const FaceSurface::Rectangle& range, int axis,
             bool high)
        : across(axis),
          fixed(high ? range.high[axis] : range.low[axis]),
          held(high ? 1 : -1),
          curve(axis == 0 ? surface->UIso(fixed) : surface->VIso(fixed), range.low[1 - axis],
                range.high[1 - axis]),
          box(curve_box(curve)) {
        is_point = true;
        constexpr int places = 8;
        const double first = curve.FirstParameter(),
                     step = (curve.LastParameter() - first) / places;
        for (int i = 1; i <= places && is_point; ++i)
            is_point =
                curve.Value(first).IsEqual(curve.Value(first + i * step), Precision::Confusion());
        if (!is_point) extrema.Initialize(curve, first, first + places * step, parameter_tolerance);
    }
    [[nodiscard]] Vec2 at(double along) const {
        return across == 0 ? Vec2(fixed, along) : Vec2(along, fixed);
    }
    int across;
    double fixed;
    int held;  ///< as FaceSurface::Foot::held
    GeomAdaptor_Curve curve;
    Bnd_Box box;
    bool is_point;  ///< as at poles
    Extrema_ExtPC extrema;
};

struct FaceTool {
    FaceTool(const TopoDS_Face& face, const FaceSurface& of) : surface(face, Standard_False) {
        if (of.unbounded()) return;
        const Handle(Geom_Surface) whole = BRep_Tool::Surface(face);
        for (const int across : {0, 1})
            for (const bool high : {false, true})
                sides.push_back(std::make_unique<SideTool>(
                    whole, FaceSurface::Rectangle{of.low(), of.high()}, across, high));
    }
    BRepAdaptor_Surface surface;
    std::vector<std::unique_ptr<SideTool>> sides;
};

/// Calls the kernel with one piece, made when it is asked for the first time.
struct PieceTool {
    template <class Visit>
    void each(const BRepAdaptor_Surface& surface, const Piece& piece, const Vec3& query,
              Visit&& visit) {
        const Vec2 &low = piece.range.low, &high = piece.range.high;
        if (piece.closed_form) {
            if (!whole)
                whole.emplace().Initialize(surface, low[0], high[0], low[1], high[1],
                                           parameter_tolerance, parameter_tolerance);
            found(*whole, query, visit);
            return;
        }
        if (!part) {
            part.emplace().SetFlag(Extrema_ExtFlag_MIN);
            part->Initialize(surface, starts, starts, low[0], high[0], low[1], high[1],
                             parameter_tolerance, parameter_tolerance);
        }
        found(*part, query, visit);
    }

  private:
    template <class Extrema, class Visit>
    static void found(Extrema& extrema, const Vec3& query, Visit&& visit) {
        extrema.Perform(kernel_point(query));
        if (!extrema.IsDone()) return;
        for (int i = 1; i <= extrema.NbExt(); ++i) {
            Standard_Real u = 0, v = 0;
            extrema.Point(i).Parameter(u, v);
            visit(Vec2(u, v));
        }
    }

    std::optional<Extrema_ExtPS> whole;
    std::optional<Extrema_GenExtPS> part;
};

struct EdgeTool {
    explicit EdgeTool(const ModelEdge& edge)
        : curve(edge.curve, edge.first, edge.last), box(curve_box(curve)) {
        extrema.Initialize(curve, edge.first, edge.last, parameter_tolerance);
    }
    GeomAdaptor_Curve curve;
    Bnd_Box box;
    Extrema_ExtPC extrema;
};

CurveHit hit_at(int number, const ModelEdge& edge, double t, const Vec3& query) {
    const Vec3 point = edge.at(t);
    return {number, t, point, (point - query).norm()};
}

/// But for its ends.
void find_on_edge(EdgeTool& tool, int number, const ModelEdge& edge, const Vec3& query,
                  std::vector<CurveHit>& hits) {
    tool.extrema.Perform(kernel_point(query));
    if (!tool.extrema.IsDone()) return;
    for (int i = 1; i <= tool.extrema.NbExt(); ++i)
        if (tool.extrema.IsMin(i))
            hits.push_back(hit_at(number, edge, tool.extrema.Point(i).Parameter(), query));
}

/// Whether the distance from the query is least there by first and second order; rounding counts as
/// flat. The kernel also gives maxima, and where its steps have ended at the bounds of a piece.
bool is_minimum(const BRepAdaptor_Surface& surface, const Vec2& at, const Vec3& query) {
    constexpr double flat = 1e-9;
    constexpr double level = 1e-6;  // cosine; feet are as near to exact as that of the diagonal
    gp_Pnt p;
    gp_Vec du, dv, duu, dvv, duv;
    surface.D2(at[0], at[1], p, du, dv, duu, dvv, duv);
    const gp_Vec way(kernel_point(query), p);
    // By parameters that are lengths.
    const double u = std::max(du.Magnitude(), 1e-300), v = std::max(dv.Magnitude(), 1e-300);
    const double off = std::max(std::abs(way.Dot(du)) / u, std::abs(way.Dot(dv)) / v);
    if (off > level * way.Magnitude() + Precision::Confusion()) return false;
    const double uu = 1.0 + way.Dot(duu) / (u * u), vv = 1.0 + way.Dot(dvv) / (v * v),
                 uv = (du.Dot(dv) + way.Dot(duv)) / (u * v);
    return uu > -flat && vv > -flat && uu * vv - uv * uv > -flat * (1.0 + uu * vv);
}

}  // namespace

/// What one query has for itself.
struct KernelExtrema::Tools {
    Tools(const std::vector<TopoDS_Face>& faces, const std::vector<FaceSurface>& surfaces,
          const std::vector<ModelEdge>& edges, std::size_t pieces)
        : of_pieces(pieces) {
        for (std::size_t f = 0; f < faces.size(); ++f)
            of_faces.push_back(std::make_unique<FaceTool>(faces[f], surfaces[f]));
        for (const ModelEdge& edge : edges) of_edges.push_back(std::make_unique<EdgeTool>(edge));
    }
    std::vector<std::unique_ptr<FaceTool>> of_faces;
    std::vector<std::unique_ptr<EdgeTool>> of_edges;
    std::vector<PieceTool> of_pieces;
};

struct KernelExtrema::State {
    std::vector<TopoDS_Face> faces;
    const std::vector<FaceSurface>& surfaces;
    const std::vector<ModelEdge>& edges;
    std::vector<Piece> pieces;
    std::mutex mutex;
    std::vector<std::unique_ptr<Tools>> idle;

    std::unique_ptr<Tools> take() {
        const std::lock_guard lock(mutex);
        if (idle.empty()) return std::make_unique<Tools>(faces, surfaces, edges, pieces.size());
        std::unique_ptr<Tools> tools = std::move(idle.back());
        idle.pop_back();
        return tools;
    }
    void give_back(std::unique_ptr<Tools> tools) {
        const std::lock_guard lock(mutex);
        idle.push_back(std::move(tools));
    }

    [[nodiscard]] FaceSurface::Foot foot_at(const FaceTool& tool, std::size_t face, const Vec2& uv,
                                            const Vec3& query) const {
        FaceSurface::Foot foot;
        foot.uv = uv;
        foot.point = vec(tool.surface.Value(uv[0], uv[1]));
        foot.normal = surfaces[face].normal(uv);
        foot.distance = (foot.point - query).norm();
        return foot;
    }
    void find_on_piece(Tools& tools, std::size_t number, const Vec3& query,
                       std::vector<SurfaceFoot>& feet) const {
        const Piece& piece = pieces[number];
        FaceTool& face = *tools.of_faces[piece.face];
        tools.of_pieces[number].each(face.surface, piece, query, [&](const Vec2& uv) {
            if (surfaces[piece.face].contains(uv) && is_minimum(face.surface, uv, query))
                feet.push_back({int(piece.face), -1, foot_at(face, piece.face, uv, query)});
        });
    }
    void find_on_side(const FaceTool& tool, SideTool& side, std::size_t face, const Vec3& query,
                      std::vector<SurfaceFoot>& feet) const {
        const auto add = [&](double along) {
            const Vec2 uv = side.at(along);
            if (!surfaces[face].contains(uv)) return;
            feet.push_back({int(face), -1, foot_at(tool, face, uv, query)});
            feet.back().foot.held[std::size_t(side.across)] = side.held;
        };
        add(side.curve.FirstParameter());
        add(side.curve.LastParameter());
        if (side.is_point) return;
        side.extrema.Perform(kernel_point(query));
        if (!side.extrema.IsDone()) return;
        for (int i = 1; i <= side.extrema.NbExt(); ++i)
            if (side.extrema.IsMin(i)) add(side.extrema.Point(i).Parameter());
    }
};

KernelExtrema::KernelExtrema(std::vector<TopoDS_Face> faces,
                             const std::vector<FaceSurface>& surfaces,
                             const std::vector<ModelEdge>& edges)
    : state_(new State{std::move(faces), surfaces, edges, {}, {}, {}}) {
    state_->pieces = pieces_of(state_->faces, surfaces);
}

KernelExtrema::~KernelExtrema() = default;

void KernelExtrema::find(const Vec3& query, double beyond, std::vector<SurfaceFoot>& feet,
                         std::vector<CurveHit>& hits) const {
    feet.clear();
    hits.clear();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t e = 0; e < state_->edges.size(); ++e)
        for (const double end : {state_->edges[e].first, state_->edges[e].last}) {
            hits.push_back(hit_at(int(e), state_->edges[e], end, query));
            nearest = std::min(nearest, hits.back().distance);
        }
    const Bnd_Box at(kernel_point(query), kernel_point(query));
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t p = 0; p < state_->pieces.size(); ++p)
        order.emplace_back(state_->pieces[p].box.Distance(at), p);
    std::sort(order.begin(), order.end());
    std::unique_ptr<Tools> tools = state_->take();
    for (const auto& [distance, p] : order) {
        if (distance > nearest + beyond) break;
        const std::size_t known = feet.size();
        state_->find_on_piece(*tools, p, query, feet);
        for (std::size_t i = known; i < feet.size(); ++i)
            nearest = std::min(nearest, feet[i].foot.distance);
    }
    for (std::size_t f = 0; f < state_->faces.size(); ++f)
        for (const auto& side : tools->of_faces[f]->sides)
            if (side->box.Distance(at) <= nearest + beyond)
                state_->find_on_side(*tools->of_faces[f], *side, f, query, feet);
    for (std::size_t e = 0; e < state_->edges.size(); ++e)
        if (tools->of_edges[e]->box.Distance(at) <=
            nearest + beyond + 2.0 * state_->edges[e].tolerance)
            find_on_edge(*tools->of_edges[e], int(e), state_->edges[e], query, hits);
    state_->give_back(std::move(tools));
}

}  // namespace patchwright::occ
