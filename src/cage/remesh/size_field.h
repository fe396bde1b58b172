// How long the edges of a cage should be, by curvature of surface and feature curves.
#pragma once

#include "cage/poll.h"
#include "geom/editable_mesh.h"

#include <patchwright/cage/make_cage.h>
#include <patchwright/geom/model_surface.h>

#include <vector>

namespace patchwright::cage {

/// The angle, radians, that an edge may span on a surface of this curvature so that a fit meets the
/// tolerance after one refinement of the cage.
/// @param diagonal   of the model, millimetres
/// @param curvature  > 0, 1/mm
double angle_of_edge(double tolerance_rel, double diagonal, double curvature);

struct SizeOptions {
    double tolerance_rel = 1e-3;  ///< of the diagonal: what the cage is to be fitted to
    double least_rel = 8e-3;      ///< of the diagonal: shortest edge asked for
    double largest_rel = 0.25;    ///< of the diagonal: longest
    double growth = 0.6;          ///< by how much the length may grow per length of way
    double fineness = 1.0;        ///< divides lengths by curvature and the shortest one
    double scale = 1.0;           ///< multiplies all lengths
    std::vector<FinerRegion> finer_at;
};

/// Wanted lengths, one a vertex of a mesh that changes.
class SizeField {
  public:
    SizeField(const geom::EditableMesh& mesh, const geom::ModelSurface& reference,
              const SizeOptions& options, Poll& poll);

    [[nodiscard]] double at(int v) const { return size_[std::size_t(v)]; }
    /// For the vertex that was last added, between a and b.
    void add_vertex(int a, int b);
    /// Lets lengths grow no faster than asked for.
    void limit_growth();

  private:
    [[nodiscard]] double by_curvature(int v) const;
    /// A ball of a FinerRegion, and the length that it asks for at its middle.
    struct FinerBall {
        FinerRegion::Ball ball;
        double factor, size;
    };
    [[nodiscard]] double near_finer_regions(int v, double size,
                                            const std::vector<FinerBall>& balls) const;
    [[nodiscard]] double near_finer_regions(int v, double size) const;
    void add_finer_regions();

    const geom::EditableMesh& mesh_;
    const geom::ModelSurface& reference_;
    SizeOptions options_;
    std::vector<double> size_;
    std::vector<std::vector<FinerBall>> finer_;  ///< one a region
};

}  // namespace patchwright::cage
