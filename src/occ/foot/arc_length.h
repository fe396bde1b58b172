// Arc length of edges.
#pragma once

#include "occ/foot/model_edges.h"

#include <vector>

namespace patchwright::occ {

/// Arc length along one edge, in the direction of its curve, and its inverse. Const functions are
/// thread-safe.
class ArcLength {
  public:
    /// By Gauss's rule on pieces that are halved until both halves add up to the whole.
    explicit ArcLength(const ModelEdge& edge);

    [[nodiscard]] double length() const { return arc_.back(); }
    /// Arc length from the edge's start to parameter t.
    [[nodiscard]] double at(double t) const;
    /// The parameter at this arc length; clamped to the edge.
    [[nodiscard]] double parameter(double arc) const;

  private:
    [[nodiscard]] double integrate(double a, double b) const;
    void add(double a, double b, double whole, int depth);

    Handle(Geom_Curve) curve_;
    std::vector<double> t_, arc_;  ///< ends of the pieces
};

}  // namespace patchwright::occ
