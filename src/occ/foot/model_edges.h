// The edges of a model as curves, and what kind of feature each is.
#pragma once

#include "occ/foot/face_surface.h"

#include <patchwright/geom/features.h>

#include <Geom2d_Curve.hxx>
#include <Geom_Curve.hxx>
#include <TopoDS_Shape.hxx>

#include <optional>
#include <vector>

namespace patchwright::occ {

enum class EdgeKind { Smooth, Sharp, Free };

/// One use of an edge by a face.
struct FaceOfEdge {
    int face = -1;
    Handle(Geom2d_Curve) curve;  ///< in the face's parameters
    double first = 0.0, last = 0.0;
    bool reversed = false;  ///< the face's boundary runs against the edge's curve
};

struct ModelEdge {
    Handle(Geom_Curve) curve;
    double first = 0.0, last = 0.0;
    double tolerance = 0.0;
    int start = -1, end = -1;  ///< vertex numbers; equal for closed edges
    int shape_edge = -1;       ///< number in TopExp::MapShapes order, from 0
    std::vector<FaceOfEdge> uses;
    EdgeKind kind = EdgeKind::Smooth;
    /// Dihedral deviation from flat as sampled along the edge, radians; 0 for free edges.
    double least_angle = 0.0, greatest_angle = 0.0;

    [[nodiscard]] geom::Vec3 at(double t) const { return vec(curve->Value(t)); }
    /// Unit tangent in the direction of growing t; zero where there is none.
    [[nodiscard]] geom::Vec3 tangent(double t) const;
};

/// The using face's parameters beside the edge at curve parameter t; zero without a p-curve.
Vec2 parameters_beside(const ModelEdge& edge, const FaceOfEdge& use, double t);

/// Outward normal of the using face beside the edge at curve parameter t; zero where it has none.
geom::Vec3 normal_beside(const ModelEdge& edge, const FaceOfEdge& use, double t,
                         const std::vector<FaceSurface>& surfaces);

/// A vertex where features meet or end at an angle, or without a tangent plane.
struct NetworkCorner {
    int vertex = -1;
    geom::CornerKind kind = geom::CornerKind::Junction;
};

struct EdgeNetwork {
    std::vector<ModelEdge> edges;  ///< without degenerate ones
    std::vector<geom::Vec3> vertices;
    std::vector<NetworkCorner> corners;  ///< by vertex
    double sharp_angle_rad = 0.0;        ///< as given
};

/// Edges are sharp when most of their normals on both sides differ by more than `sharp_angle_rad`;
/// those that are so on a good part of their length only are cut where that begins and ends.
/// @param faces, surfaces  the model's faces and what is under them, in the same order
EdgeNetwork collect_edges(const TopoDS_Shape& shape, const std::vector<TopoDS_Face>& faces,
                          const std::vector<FaceSurface>& surfaces, double sharp_angle_rad);

}  // namespace patchwright::occ
