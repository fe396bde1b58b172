#include "occ/foot/reference_mesh.h"

#include "occ/foot/divide_triangles.h"
#include "occ/kernel_mesh.h"
#include "occ/kernel_progress.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/geom/nearest.h>

#include <BRepBuilderAPI_Copy.hxx>
#include <BRepLib.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_Curve.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <Precision.hxx>
#include <ShapeFix_Edge.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace patchwright::occ {

using geom::Vec3;

namespace {

/// Measured in about a tenth of a second on one core.
constexpr std::size_t triangles_between_polls = 16384;
// Deviations are seen at a few points of a triangle only.
constexpr double safety = 1.5, turn_safety = 2.0;
/// Of the kernel's triangles; with larger ones searches start too far from their feet.
constexpr double angular_deflection_rad = 0.3;
/// Added to what is sampled, for planes to have a margin for rounding, too.
constexpr double least_turn_rad = 1e-3;
/// A triangle that turns further has no useful bound for its normals.
constexpr double widest_turn_rad = 1.2;
/// A descent may step at once: half a radius of curvature, within these fractions of the triangle.
constexpr double stride_of_radius = 0.5, least_stride = 0.05, largest_stride = 0.25;
/// The sine of the angle at a corner of triangles that have no area but by rounding.
constexpr double flat_rel = 1e-12;
constexpr double off_face_rel = 1e-5;  // of the deflection; edges nearer than this lie on the face

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    return (geom::nearest_on_segment(p, a, b).point - p).norm();
}

using SideMap = std::map<std::pair<int, int>, std::size_t>;

// Largest distance between a piece of boundary curve, as points by parameter, and what the surface
// makes of its chord in (u, v).
template <class Curve>
double sickle_width(const FaceSurface& surface, const Vec2& a, const Vec2& b, const Curve& curve,
                    double t0, double t1) {
    constexpr int pieces = 16;
    std::array<Vec3, pieces + 1> on_chord;
    for (int i = 0; i <= pieces; ++i)
        on_chord[std::size_t(i)] = surface.at(a + (b - a) * i / pieces);
    double width = 0.0;
    for (const double s : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
        const Vec3 p = curve(t0 + s * (t1 - t0));
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < pieces; ++i)
            nearest = std::min(nearest, distance_to_segment(p, on_chord[i], on_chord[i + 1]));
        width = std::max(width, nearest);
    }
    return width;
}

// Between a face's boundary and the chords that stand for it in (u, v) lie sickles that no triangle
// covers, or that triangles cover though they are not part of the face. An edge farther off the
// face than the triangulation is no end of it: that is where the face's trim says.
void add_boundary_errors(const TopoDS_Face& face, const FaceSurface& surface,
                         const Handle(Poly_Triangulation) & mesh, const TopLoc_Location& location,
                         const SideMap& sides, std::size_t first, double deflection,
                         ReferenceMesh& into) {
    std::vector<MeshTriangle>& triangles = into.triangles;
    const double off_face = std::max(off_face_rel * deflection, 2.0 * Precision::Confusion());
    double widest = 0.0;
    for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
        const TopoDS_Edge& edge = TopoDS::Edge(it.Current());
        if (BRep_Tool::Degenerated(edge)) continue;
        double t0 = 0.0, t1 = 0.0;
        const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, t0, t1);
        const Handle(Poly_PolygonOnTriangulation) polygon =
            BRep_Tool::PolygonOnTriangulation(edge, mesh, location);
        if (curve.IsNull() || polygon.IsNull() || !polygon->HasParameters()) {
            into.covers_edges = false;
            continue;
        }
        double s0 = 0.0, s1 = 0.0;
        const Handle(Geom2d_Curve) trim = BRep_Tool::CurveOnSurface(edge, face, s0, s1);
        const bool apart = !trim.IsNull() && BRep_Tool::Tolerance(edge) > deflection;
        if (apart) into.covers_edges = false;
        const auto on_edge = [&](double t) { return vec(curve->Value(t)); };
        const auto on_trim = [&](double t) {
            return surface.at(vec(trim->Value(s0 + (t - t0) / (t1 - t0) * (s1 - s0))));
        };
        const auto& nodes = polygon->Nodes();
        const auto& at = polygon->Parameters()->Array1();
        for (int i = nodes.Lower(); i < nodes.Upper(); ++i) {
            const int k = at.Lower() + i - nodes.Lower();
            const Vec2 a = vec(mesh->UVNode(nodes(i))), b = vec(mesh->UVNode(nodes(i + 1)));
            double width = safety * sickle_width(surface, a, b, on_edge, at(k), at(k + 1));
            widest = std::max(widest, width);
            if (apart) width = safety * sickle_width(surface, a, b, on_trim, at(k), at(k + 1));
            const auto side = sides.find(std::minmax(nodes(i), nodes(i + 1)));
            if (side == sides.end()) {
                into.covers_edges = false;
                continue;
            }
            MeshTriangle& triangle = triangles[side->second];
            triangle.sickle = std::max(triangle.sickle, width);
            if (BRep_Tool::Tolerance(edge) > off_face)
                triangle.spread = std::numeric_limits<double>::infinity();
        }
    }
    for (std::size_t i = first; i < triangles.size(); ++i) triangles[i].overhang = widest;
}

void append_kernel_mesh(const TopoDS_Face& face, const FaceSurface& surface, int number,
                        const Handle(Poly_Triangulation) & mesh, const TopLoc_Location& location,
                        double deflection, ReferenceMesh& into) {
    std::vector<MeshTriangle>& triangles = into.triangles;
    SideMap sides;
    const std::size_t first = triangles.size();
    const gp_Trsf transform = location.Transformation();
    for (int i = 1; i <= mesh->NbTriangles(); ++i) {
        std::array<int, 3> node{};
        mesh->Triangle(i).Get(node[0], node[1], node[2]);
        MeshTriangle triangle;
        triangle.face = number;
        for (std::size_t k = 0; k < 3; ++k) {
            triangle.corner[k] = vec(mesh->Node(node[k]).Transformed(transform));
            triangle.uv[k] = vec(mesh->UVNode(node[k]));
            triangle.node[k] = into.nodes + node[k] - 1;
            sides[std::minmax(node[k], node[(k + 1) % 3])] = triangles.size();
        }
        triangles.push_back(triangle);
    }
    into.nodes += mesh->NbNodes();
    add_boundary_errors(face, surface, mesh, location, sides, first, deflection, into);
}

// Covers the rectangle around a face the kernel could not triangulate; what lies outside the trim
// only costs time, as feet are tested.
void append_grid(const FaceSurface& surface, int number, ReferenceMesh& into) {
    constexpr int cells = 48;
    const Vec2 range = surface.high() - surface.low();
    using GridNode = std::array<int, 2>;
    const auto add = [&](const std::array<GridNode, 3>& places) {
        MeshTriangle triangle;
        triangle.face = number;
        triangle.overhang = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [i, j] = places[k];
            triangle.uv[k] = surface.low() + Vec2(range[0] * i / cells, range[1] * j / cells);
            triangle.corner[k] = surface.at(triangle.uv[k]);
            triangle.node[k] = into.nodes + i * (cells + 1) + j;
        }
        // A face that is a curve is searched by its edges.
        const auto& [a, b, c] = triangle.corner;
        if ((b - a).cross(c - a).norm() <= flat_rel * (b - a).norm() * (c - a).norm()) return;
        into.triangles.push_back(triangle);
    };
    for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells; ++j) {
            add({GridNode{i, j}, GridNode{i + 1, j}, GridNode{i + 1, j + 1}});
            add({GridNode{i, j}, GridNode{i + 1, j + 1}, GridNode{i, j + 1}});
        }
    }
    into.nodes += (cells + 1) * (cells + 1);
    into.covers_edges = false;
}

// Widens what is known of the triangle's part of the face by one of its points.
void look_at(MeshTriangle& triangle, const FaceSurface& surface, const Vec2& uv, double& turn) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const Vec3 normal = surface.normal(uv);
    const auto curvature = surface.curvature(uv);
    const bool regular = curvature && !normal.isZero(0.0) && !triangle.normal.isZero(0.0);
    turn = std::max(turn, regular ? 2.0 * std::atan2((normal - triangle.normal).norm(),
                                                     (normal + triangle.normal).norm())
                                  : infinity);
    triangle.bend_out = std::max(triangle.bend_out, curvature ? curvature->value[1] : infinity);
    triangle.bend_in = std::max(triangle.bend_in, curvature ? -curvature->value[0] : infinity);
}

void measure(MeshTriangle& triangle, const FaceSurface& surface, double size) {
    const auto& [a, b, c] = triangle.corner;
    const Vec3 cross = (b - a).cross(c - a);
    triangle.area = 0.5 * cross.norm();
    const Vec2 ab = triangle.uv[1] - triangle.uv[0], ac = triangle.uv[2] - triangle.uv[0];
    const double hand = ab[0] * ac[1] - ab[1] * ac[0] < 0.0 ? -1.0 : 1.0;
    triangle.normal = surface.orientation() * hand * cross.normalized();
    double off = 0.0, turn = 0.0;
    constexpr int cells = 4;
    for (int i = 0; i <= cells; ++i) {
        for (int j = 0; i + j <= cells; ++j) {
            const Vec2 uv = triangle.uv[0] + (i * (triangle.uv[1] - triangle.uv[0]) +
                                              j * (triangle.uv[2] - triangle.uv[0])) /
                                                 cells;
            const Vec3 p = surface.at(uv), w = geom::nearest_weights(p, triangle.corner);
            off = std::max(off, (w[0] * a + w[1] * b + w[2] * c - p).norm());
            look_at(triangle, surface, uv, turn);
        }
    }
    // The triangulation passes over short spans, which may bend as sharply as kinks.
    surface.each_span(box_of(triangle.uv), [&](const FaceSurface::Rectangle& span) {
        for (const double x : {0.03, 0.5, 0.97}) {
            for (const double y : {0.03, 0.5, 0.97}) {
                const Vec2 share(x, y);
                look_at(triangle, surface, span.low + share.cwiseProduct(span.high - span.low),
                        turn);
            }
        }
    });
    triangle.turn_rad = turn;
    const double widest = turn_safety * turn + least_turn_rad;
    const double spread =
        widest < widest_turn_rad ? std::tan(widest) : std::numeric_limits<double>::infinity();
    triangle.spread = std::max(triangle.spread, spread);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const double bend = std::max({triangle.bend_out, triangle.bend_in, 1e-30});
    triangle.stride = std::min(largest_stride * longest,
                               std::max(stride_of_radius / bend, least_stride * longest));
    // What is in a sickle beside the triangle is off the triangle by both.
    triangle.error = triangle.sickle + safety * off + 1e-12 * size;
}

/// What a search asks of the triangles, in the order of the tree.
void lay_out_seeds(ReferenceMesh& mesh) {
    const auto up = [](double x) {
        return std::nextafter(float(x), std::numeric_limits<float>::infinity());
    };
    const auto& numbers = mesh.tree.numbers();
    constexpr std::size_t lanes = geom::TriangleTree::lanes;
    mesh.seeds.resize(numbers.size() / lanes);
    mesh.starts.resize(numbers.size());
    for (std::size_t slot = 0; slot < numbers.size(); ++slot) {
        const std::int32_t number = numbers[slot];
        if (number < 0) continue;
        const MeshTriangle& t = mesh.triangles[std::size_t(number)];
        SeedBlock& seeds = mesh.seeds[slot / lanes];
        const std::size_t lane = slot % lanes;
        seeds.error[lane] = up(t.error);
        seeds.overhang[lane] = up(t.overhang);
        seeds.spread[lane] = up(t.spread);
        seeds.triangle[lane] = number;
        const auto& [a, b, c] = t.corner;
        const bool left_is_out = (b - a).cross(c - a).dot(t.normal) > 0.0;
        mesh.starts[slot] = {
            t.uv,
            {up(left_is_out ? t.bend_out : t.bend_in), up(left_is_out ? t.bend_in : t.bend_out)},
            float(t.stride),
            t.face};
    }
}

}  // namespace

FaceSurface::Rectangle box_of(const std::array<Vec2, 3>& uv) {
    return {uv[0].cwiseMin(uv[1]).cwiseMin(uv[2]), uv[0].cwiseMax(uv[1]).cwiseMax(uv[2])};
}

SearchableShape make_searchable(const TopoDS_Shape& shape) {
    SearchableShape result;
    result.shape = BRepBuilderAPI_Copy(shape, Standard_False, Standard_False).Shape();
    BRepLib::BuildCurves3d(result.shape);
    TopTools_IndexedMapOfShape originals, faces;
    TopExp::MapShapes(shape, TopAbs_FACE, originals);
    TopExp::MapShapes(result.shape, TopAbs_FACE, faces);
    if (originals.Extent() != faces.Extent())
        throw base::InputError("CAD model: faces were lost while copying; heal the file");
    for (int i = 1; i <= faces.Extent(); ++i) {
        const TopoDS_Face& face = TopoDS::Face(faces(i));
        for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
            const TopoDS_Edge& edge = TopoDS::Edge(it.Current());
            double first = 0.0, last = 0.0;
            if (BRep_Tool::CurveOnSurface(edge, face, first, last).IsNull())
                ShapeFix_Edge().FixAddPCurve(edge, face, Standard_False);
        }
        result.faces.push_back(face);
    }
    return result;
}

ReferenceMesh triangulate(const SearchableShape& model, const std::vector<FaceSurface>& surfaces,
                          double deflection, const base::Progress& progress) {
    IMeshTools_Parameters parameters;
    parameters.Deflection = deflection;
    parameters.Angle = angular_deflection_rad;
    parameters.InParallel = Standard_True;
    const Handle(KernelProgress) polled = new KernelProgress(progress, "reference", 0.1);
    mesh_faces(model.shape, parameters, polled->Start());
    polled->check();
    ReferenceMesh mesh;
    for (std::size_t i = 0; i < model.faces.size(); ++i) {
        mesh.first.push_back(mesh.triangles.size());
        if (surfaces[i].unbounded()) continue;
        TopLoc_Location location;
        const Handle(Poly_Triangulation) made = BRep_Tool::Triangulation(model.faces[i], location);
        if (!made.IsNull() && made->NbTriangles() > 0 && made->HasUVNodes()) {
            append_kernel_mesh(model.faces[i], surfaces[i], int(i), made, location, deflection,
                               mesh);
        } else {
            append_grid(surfaces[i], int(i), mesh);
            ++mesh.faces_without;
        }
    }
    mesh.first.push_back(mesh.triangles.size());
    BRepTools::Clean(model.shape);
    divide_coarse_triangles(mesh, surfaces, deflection);

    geom::Box3 bounds;
    for (const MeshTriangle& t : mesh.triangles)
        for (const Vec3& p : t.corner) bounds.add(p);
    std::vector<geom::TriangleTree::Corners> corners(mesh.triangles.size());
    std::vector<double> errors(mesh.triangles.size());
    for (std::size_t first = 0; first < corners.size(); first += triangles_between_polls) {
        base::report_progress(progress, "reference",
                              0.5 + 0.3 * double(first) / double(corners.size()));
        const std::size_t count = std::min(triangles_between_polls, corners.size() - first);
        base::parallel_for(count, 512, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = first + begin; i < first + end; ++i) {
                MeshTriangle& t = mesh.triangles[i];
                measure(t, surfaces[std::size_t(t.face)], bounds.diagonal());
                corners[i] = t.corner;
                errors[i] = t.error;
            }
        });
    }
    for (const MeshTriangle& t : mesh.triangles)
        if (!std::isfinite(t.error) || !(t.corner[0] + t.corner[1] + t.corner[2]).allFinite())
            throw base::InputError(fmt::format(
                "CAD model: face {} has points that are not finite; heal the file", t.face + 1));
    mesh.tree = geom::TriangleTree(corners, errors);
    lay_out_seeds(mesh);
    return mesh;
}

}  // namespace patchwright::occ
