// A reference surface that came from a file: it can also be sampled, and knows how it bends.
#pragma once

#include <patchwright/geom/reference_surface.h>
#include <patchwright/geom/surface_mesh.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::geom {

/// Of a surface at a point.
struct Curvature {
    /// Principal curvatures, least first, 1/mm; positive where the surface bends towards its
    /// outward normal: -1/r twice on a sphere.
    std::array<double, 2> value{0.0, 0.0};
    std::array<Vec3, 2> direction{Vec3::Zero(), Vec3::Zero()};  ///< unit
};

/// A point of a feature curve.
struct CurveSample {
    Vec3 point;
    int curve;      ///< number among Features::curves
    double weight;  ///< length that it stands for, mm
};

/// A triangle in the parameters of a face. All pieces together cover the surface but for what lies
/// between the faces' boundary curves and the chords of these.
struct SurfacePiece {
    int face;
    std::array<Eigen::Vector2d, 3> uv;
};

class ModelSurface : public ReferenceSurface {
  public:
    /// What shares of a model's size are of, in mm: the diagonal; of one body of a model by itself
    /// that of the whole model, so that cages are as coarse as the others'.
    [[nodiscard]] virtual double size() const { return bounds().diagonal(); }

    /// Of the face at an answer's parameters; nothing where the surface is degenerate there.
    /// @throw InvalidArgument when the answer names no face of this surface
    [[nodiscard]] virtual std::optional<Curvature> curvature(const FootPoint& foot) const = 0;

    /// Nearest point among the features of one kind; empty when there are none.
    [[nodiscard]] virtual std::optional<FeaturePoint> feature_point(const Vec3& query,
                                                                    FeatureKind kind) const = 0;

    /// About `count` points on the faces, half of them spread by area, half by how much the faces
    /// bend; plus points on edges and vertices. Deterministic.
    /// @throw InvalidArgument when the count is not positive
    [[nodiscard]] std::vector<SurfaceSample> sample(int count) const override = 0;

    [[nodiscard]] virtual std::vector<SurfacePiece> pieces() const = 0;
    /// The point of a face at its parameters and the normal there; the distance is 0.
    /// @pre the face is one of this surface's
    [[nodiscard]] virtual FootPoint point_on_face(int face, const Eigen::Vector2d& uv) const = 0;

    /// Triangles that share their vertices, with the features they lie on.
    /// @param deflection_mm  largest distance of a triangle from its face, as far as the source of
    ///                       the triangles keeps it
    /// @throw InputError when nothing can be triangulated
    [[nodiscard]] virtual SurfaceMesh surface_mesh(double deflection_mm) const = 0;
    /// One a face that SurfaceMesh::faces names; empty strings where the file gives no name.
    [[nodiscard]] virtual std::vector<std::string> face_names() const = 0;
    /// Whether those faces are CAD faces, with curves as borders. If not, they are regions of
    /// triangles, whose borders are as jagged as the triangles.
    [[nodiscard]] virtual bool has_cad_faces() const = 0;

    /// Points on all feature curves of one kind, evenly spaced by arc length, both ends included.
    /// @throw InvalidArgument when the spacing is not positive
    [[nodiscard]] std::vector<CurveSample> sample_curves(FeatureKind kind, double spacing_mm) const;
};

}  // namespace patchwright::geom
#pragma GCC visibility pop
