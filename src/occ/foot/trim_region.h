// Which part of a surface's parameter plane belongs to a face.
#pragma once

#include "occ/kernel_points.h"

#include <Geom2d_Curve.hxx>
#include <TopoDS_Face.hxx>

#include <cstdint>
#include <limits>
#include <vector>

namespace patchwright::occ {

/// The trimmed region of a face in (u, v), tested by counting crossings of a ray in +u with the
/// p-curves: by chords where the point is clear of them, by halving the true curve where it is not.
/// Const functions are thread-safe: curves are evaluated without the kernel's caches.
class TrimRegion {
  public:
    TrimRegion() = default;
    /// @pre every edge of `face` has a p-curve
    explicit TrimRegion(const TopoDS_Face& face);

    /// Smallest rectangle around the region.
    [[nodiscard]] const Vec2& low() const { return low_; }
    [[nodiscard]] const Vec2& high() const { return high_; }
    [[nodiscard]] bool empty() const { return chords_.empty(); }
    /// The region is that rectangle.
    [[nodiscard]] bool is_rectangle() const { return rectangle_; }
    [[nodiscard]] bool contains(const Vec2& uv) const;

  private:
    struct Chord {
        Vec2 start, end;
        Vec2 bulge;          ///< how far the curve may leave the chord, in u and in v
        double t0, t1;       ///< the curve's parameters at start and end
        std::int32_t curve;  ///< -1: the chord itself, closing a gap between two p-curves
    };
    /// One p-curve as the boundary runs through it.
    struct EdgeRun {
        Handle(Geom2d_Curve) curve;
        double first = 0.0, last = 0.0;
        Vec2 start, end;
    };

    std::vector<EdgeRun> runs_of(const TopoDS_Shape& wire, const TopoDS_Face& face);
    void add_curve(const EdgeRun& run);
    void split(Chord chord, int depth);
    void close_gaps(const std::vector<EdgeRun>& runs);
    void measure();
    void make_bands();
    [[nodiscard]] bool all_on_rectangle() const;
    [[nodiscard]] bool crosses(const Chord& chord, const Vec2& uv, int depth) const;

    std::vector<Handle(Geom2d_Curve)> curves_;
    std::vector<Chord> chords_;
    /// Chords sorted by band of v: band b holds band_chords_[band_start_[b] .. band_start_[b + 1]).
    std::vector<std::int32_t> band_start_, band_chords_;
    Vec2 low_ = Vec2::Constant(std::numeric_limits<double>::infinity());
    Vec2 high_ = Vec2::Constant(-std::numeric_limits<double>::infinity());
    bool rectangle_ = false;
};

}  // namespace patchwright::occ
