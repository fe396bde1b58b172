// Which curves of the reference one chain of sharp edges follows.
#pragma once

#include "fit/match/feature_match.h"
#include "geom/polyline.h"

#include <patchwright/geom/curve_ends.h>

#include <array>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace patchwright::fit {

using geom::Polyline;

/// In parts of the reference's diagonal: points closer to each other coincide. Above the rounding
/// of CAD files, below any feature.
inline constexpr double coincidence_rel = 1e-6;

/// Where a path begins or ends: a corner of the reference or a point of one of its curves.
struct Stop {
    int corner = -1;
    geom::Vec3 point = geom::Vec3::Zero();
    bool ends_curve = false;
};

/// An end of a chain without a corner, and how far it may go for the end of a curve.
struct LooseEnd {
    geom::Vec3 point = geom::Vec3::Zero();
    double reach = 0.0;
    bool dart = false;  ///< ends within the surface
};

/// Finds paths along curves for chains of one kind.
class ChainMatcher {
  public:
    /// @param reach  how far a chain may be from its path, on average; millimetres
    /// @pre `reference` and `curve_ends` outlive it
    ChainMatcher(const geom::ReferenceSurface& reference, const geom::CurveEnds& curve_ends,
                 geom::FeatureKind kind, double reach);

    /// @param line  of the chain; is moved with its ends
    /// @param ends  the corners of the reference that the chain's ends have, if any
    /// @param loose  ends that are to go to the end of a curve, if one is near
    /// @param stops  where the path begins and ends
    /// @return an empty path where none is within reach
    FeaturePath match(Polyline& line, bool closed, std::array<int, 2> ends,
                      const std::array<LooseEnd, 2>& loose, std::array<Stop, 2>& stops) const;

    /// Mean distance of a moved chain from a whole curve, plus that of the curve from the chain.
    [[nodiscard]] double distance(int curve, const Polyline& line) const;

  private:
    struct ScoredPath {
        FeaturePath path;
        double score = std::numeric_limits<double>::infinity();
    };
    struct Link {
        int to;
        FeaturePiece piece;
        double penalty;  ///< see kind_mismatch_penalty()
    };

    /// The chain goes where its ends go.
    static void move_ends(Polyline& line, std::array<int, 2> ends,
                          const std::array<Stop, 2>& stops);
    [[nodiscard]] std::optional<Stop> nearest_stop(const geom::Vec3& q) const;
    /// The nearest place where a curve begins or ends, but for corners, as where a smooth edge
    /// begins at a sharp rim; for darts also corners where one ends within the surface.
    [[nodiscard]] std::optional<Stop> nearest_end(const LooseEnd& end) const;
    /// The path whose sections between these shares of the chain are the best for each.
    [[nodiscard]] ScoredPath scored_path(const Polyline& line, const std::vector<double>& shares,
                                         const std::array<Stop, 2>& ends) const;
    /// From a piece to the chain.
    [[nodiscard]] double mean_distance(const FeaturePiece& piece, const Polyline& line) const;
    /// From the chain to a path.
    [[nodiscard]] double mean_distance_to(const FeaturePath& path, const Polyline& line) const;
    /// Added to distances so that of two paths at distance zero the shorter one costs less.
    [[nodiscard]] double length_cost() const;
    /// The pieces of all curves of the kind between corners and these two stops, which are nodes
    /// 0 and 1; place p of CurveEnds is node p + 2. A stop may lie on several curves.
    [[nodiscard]] std::vector<std::vector<Link>> links(const Stop& from, const Stop& to) const;
    /// The way along curves whose distance from the chain, summed along the way, is least.
    [[nodiscard]] std::optional<FeaturePath> shortest_path(const Polyline& line, const Stop& from,
                                                           const Stop& to) const;

    const geom::ReferenceSurface& reference_;
    const geom::Features& features_;
    const geom::CurveEnds& curve_ends_;
    geom::FeatureKind kind_;
    double reach_;
    double coincidence_mm_;
};

}  // namespace patchwright::fit
