// Where the points of a chain belong on its path, in their order.
#pragma once

#include "fit/match/feature_match.h"
#include "geom/polyline.h"

#include <vector>

namespace patchwright::fit {

/// A chain and its path keep their order: where a path comes back beside itself, as along both
/// edges of a blunt trailing edge, the nearest point may be one of the other side.
class PathAlignment {
  public:
    /// @param points  that will be asked for at a time
    /// @pre the path is not empty, and `reference` outlives it
    PathAlignment(const geom::ReferenceSurface& reference, FeaturePath path, bool closed,
                  std::size_t points);

    /// Nearest points of the path under the condition that the later of two points of the chain is
    /// not earlier on the path, with the least sum of squared distances: dynamic programming over
    /// segments between places along the path, then the nearest point on this one or the next ones.
    /// Far from the path, distances along it are kept as well: twice as far as a point is from its
    /// own target it follows those of its neighbours.
    /// @param chain  its points from one end to the other
    [[nodiscard]] std::vector<geom::FeaturePoint> targets(const geom::Polyline& chain) const;

  private:
    struct Place {
        double arc;  ///< along the path
        geom::Vec3 point, tangent;
    };
    [[nodiscard]] Place place_at(std::size_t piece, double arc) const;
    /// Those of a piece, in steps of that length or less where it turns.
    void add_places(std::size_t piece, double step);
    /// For each point the number of the place that its segment begins at.
    [[nodiscard]] std::vector<std::size_t> segments_of(const geom::Polyline& chain) const;
    struct Hit {
        geom::FeaturePoint point;
        double arc = 0.0;  ///< along the path
    };
    /// Between two arc lengths along the path.
    [[nodiscard]] Hit nearest_between(double from, double to, const geom::Vec3& q) const;
    [[nodiscard]] geom::FeaturePoint point_at(double arc, const geom::Vec3& q) const;
    /// Arc lengths near those of the hits that differ as the points of the chain do.
    [[nodiscard]] std::vector<double> evened(const std::vector<Hit>& hits,
                                             const geom::Polyline& chain) const;

    const geom::ReferenceSurface& reference_;
    FeaturePath path_;
    bool closed_;
    std::vector<double> start_;  ///< of pieces, along the path, and its length
    std::vector<Place> places_;  ///< in order; of a closed chain with some of the next turns
};

}  // namespace patchwright::fit
