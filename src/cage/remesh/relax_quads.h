// Quads and triangles of a cage brought into shape.
#pragma once

#include "cage/poll.h"
#include "cage/remesh/curve_ways.h"
#include "cage/remesh/polygon_mesh.h"

#include <patchwright/geom/model_surface.h>

#include <map>
#include <utility>
#include <vector>

namespace patchwright::cage {

class QuadRelaxation {
  public:
    QuadRelaxation(PolygonMesh& polygons, const geom::ModelSurface& reference, Poll& poll)
        : polygons_(polygons), reference_(reference), ways_(reference, poll), poll_(poll) {}

    /// Moves vertices on the model so that the faces around each become nearer to squares and
    /// regular triangles. Vertices on feature curves slide along them, corners stay. However often
    /// it is called, edges on curves that bend stay near the lengths that they had first.
    void run();

  private:
    void find_shared_corners();
    [[nodiscard]] double quality(int polygon, int v, const geom::Vec3& p) const;
    [[nodiscard]] double badness(int v, const geom::Vec3& p) const;
    [[nodiscard]] geom::Vec3 normal_at(int v) const;
    void relax_smooth(int v);
    void relax_on_curve(int v);

    PolygonMesh& polygons_;
    const geom::ModelSurface& reference_;
    CurveWays ways_;
    Poll& poll_;
    /// One a polygon: its corners in sectors of several faces between sharp edges.
    std::vector<std::vector<std::size_t>> shared_corners_;
    std::map<std::pair<int, int>, double> first_way_;  ///< ways along curves at first, millimetres
};

}  // namespace patchwright::cage
