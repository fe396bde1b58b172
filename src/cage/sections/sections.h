// Plane sections of a triangle mesh.
#pragma once

#include "cage/sections/spine.h"

#include <patchwright/geom/surface_mesh.h>

#include <vector>

namespace patchwright::cage {

/// One connected component of a triangle mesh.
struct SurfaceBody {
    const geom::SurfaceMesh* mesh = nullptr;
    std::vector<int> triangles;
};

std::vector<SurfaceBody> bodies_of(const geom::SurfaceMesh& mesh);

/// Where a section crosses a feature curve.
struct Crossing {
    int point;  ///< number in the loop
    int curve;
};

/// One line of a section. It runs counter-clockwise around the body seen against the plane's
/// normal: along normal x outward.
struct SectionLoop {
    std::vector<geom::Vec3> points;
    bool closed = true;
    std::vector<Crossing> crossings;

    [[nodiscard]] double length() const;
    void reverse();
};

/// The lines along which a body ends, with the body on their left seen from outside: at the lower
/// end of a span they run as sections do. Crossings are where other feature curves reach them.
std::vector<SectionLoop> rims(const SurfaceBody& body);

/// Cuts bodies across a spine.
class Slicer {
  public:
    Slicer(const SurfaceBody& body, Spine spine);

    [[nodiscard]] std::vector<SectionLoop> cut(double height) const;
    [[nodiscard]] double low() const { return low_; }
    [[nodiscard]] double high() const { return high_; }
    [[nodiscard]] double height(int vertex) const { return heights_[std::size_t(vertex)]; }
    /// Whether a vertex of the mesh is one of the body's.
    [[nodiscard]] bool holds(int vertex) const { return mine_[std::size_t(vertex)] != 0; }
    [[nodiscard]] const Spine& spine() const { return spine_; }
    [[nodiscard]] const SurfaceBody& body() const { return *body_; }

  private:
    const SurfaceBody* body_;
    Spine spine_;
    std::vector<double> heights_;
    std::vector<char> mine_;
    double low_ = 0.0, high_ = 0.0;
};

}  // namespace patchwright::cage
