// Extrema of distances by the CAD kernel, in place of the search: slow, but of other making.
#pragma once

#include "occ/foot/beside_foot.h"
#include "occ/foot/curve_search.h"

#include <TopoDS_Face.hxx>

#include <memory>
#include <vector>

namespace patchwright::occ {

/// The kernel's local minima on faces and edges. Its tools keep what they did last, so that each
/// query takes a set of them for itself; results do not depend on which one.
class KernelExtrema {
  public:
    /// @param surfaces, edges  of the model, which outlive this
    KernelExtrema(std::vector<TopoDS_Face> faces, const std::vector<FaceSurface>& surfaces,
                  const std::vector<ModelEdge>& edges);
    ~KernelExtrema();
    KernelExtrema(const KernelExtrema&) = delete;
    KernelExtrema& operator=(const KernelExtrema&) = delete;

    /// All that are no farther than the nearest one and `beyond`, and perhaps others.
    /// @param feet  within the trims of their faces; slots are none. Those at the end of a surface
    ///              are held there and perhaps no minima of the distance across
    /// @param hits  ends of edges among them
    void find(const geom::Vec3& query, double beyond, std::vector<SurfaceFoot>& feet,
              std::vector<CurveHit>& hits) const;

  private:
    struct Tools;
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace patchwright::occ
