// Which curves of the reference one chain of sharp edges follows.
#pragma once

#include "fit/match/feature_match.h"
#include "geom/polyline.h"

#include <patchwright/geom/curve_ends.h>

#include <array>
#include <functional>
#include <optional>
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

/// An end of a chain without a corner, and how far it may go for the end of a curve. Control points
/// of cages that are made are on the model; of fitted ones limit points are.
struct LooseEnd {
    geom::Vec3 control = geom::Vec3::Zero(), limit = geom::Vec3::Zero();
    double reach = 0.0;  ///< from the nearer one
    bool dart = false;   ///< ends within the surface
};

/// Factor of the distance of a chain to curves of another kind; infinite where it may not follow
/// them.
double kind_mismatch_penalty(geom::FeatureKind chain, geom::FeatureKind curve);

/// Finds paths along curves for chains of one kind.
class ChainMatcher {
  public:
    /// @param reach  how far a chain may be from its path, on average; millimetres
    /// @param poll  called while a path is looked for; may throw
    /// @pre `reference`, `curve_ends` and `poll` outlive it
    ChainMatcher(const geom::ReferenceSurface& reference, const geom::CurveEnds& curve_ends,
                 geom::FeatureKind kind, double reach, const std::function<void()>& poll);

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
    /// The chain goes where its ends go.
    static void move_ends(Polyline& line, std::array<int, 2> ends,
                          const std::array<Stop, 2>& stops);
    [[nodiscard]] std::optional<Stop> nearest_stop(const geom::Vec3& q) const;
    /// The nearest place where a curve begins or ends, but for corners, as where a smooth edge
    /// begins at a sharp rim; for darts also corners where one ends within the surface.
    [[nodiscard]] std::optional<Stop> nearest_end(const LooseEnd& end) const;
    /// Whether it has an edge of the chain's kind, or one that is not quite smooth.
    [[nodiscard]] bool is_bent(const FeaturePath& path) const;
    /// Added to distances so that of two paths at distance zero the shorter one costs less.
    [[nodiscard]] double length_cost() const;

    const geom::ReferenceSurface& reference_;
    const geom::Features& features_;
    const geom::CurveEnds& curve_ends_;
    geom::FeatureKind kind_;
    double reach_;
    const std::function<void()>& poll_;
    double coincidence_mm_;
};

}  // namespace patchwright::fit
