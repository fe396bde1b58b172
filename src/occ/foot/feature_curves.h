// Chains of edges between corners, with arc length and nearest points.
#pragma once

#include "occ/foot/arc_length.h"
#include "occ/foot/curve_search.h"

#include <patchwright/geom/features.h>
#include <patchwright/geom/reference_surface.h>

#include <array>
#include <optional>
#include <vector>

namespace patchwright::occ {

/// Chains the edges of a network to feature curves. Curves are numbered by kind (sharp, free,
/// smooth) and by their lowest edge.
/// @pre the network outlives it
class FeatureCurves {
  public:
    FeatureCurves() = default;
    /// @param deflection, size  as for CurveSearch
    FeatureCurves(const EdgeNetwork& network, double deflection, double size);

    [[nodiscard]] const geom::Features& features() const { return features_; }
    /// @pre 0 <= curve < features().curves.size(); a piece is not empty
    [[nodiscard]] geom::FeaturePoint nearest(int curve, const geom::Vec3& query,
                                             const std::optional<geom::ArcRange>& within) const;
    /// @pre as above
    [[nodiscard]] geom::FeaturePoint at(int curve, double arc_length) const;
    /// Number of the curve that an edge of the network is part of.
    [[nodiscard]] int curve_of(int edge) const { return places_[std::size_t(edge)].curve; }
    /// One an edge that has one or two faces.
    [[nodiscard]] std::vector<geom::FaceBorder> face_borders() const;
    /// A hit on one of the network's edges as a point of its curve.
    [[nodiscard]] geom::FeaturePoint point_of(const CurveHit& hit) const;

  private:
    struct EdgePiece {
        int edge = -1;
        bool reversed = false;
        double start = 0.0;  ///< arc length of the chain where the piece starts
    };
    struct EdgeChain {
        std::vector<EdgePiece> pieces;
        CurveSearch search;
    };
    /// Where an edge is.
    struct CurvePlace {
        int curve = -1, piece = -1;
    };
    class Chaining;

    void measure(std::size_t curve);
    void index_corners();
    [[nodiscard]] std::vector<std::array<double, 2>> parameters_within(
        const EdgeChain& chain, const geom::FeatureCurve& curve, int edge,
        const geom::ArcRange& within) const;

    const EdgeNetwork* network_ = nullptr;
    std::vector<ArcLength> arcs_;     ///< one an edge
    std::vector<CurvePlace> places_;  ///< one an edge
    std::vector<EdgeChain> chains_;
    geom::Features features_;
};

}  // namespace patchwright::occ
