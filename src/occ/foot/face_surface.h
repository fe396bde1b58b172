// The surface under a face: evaluation, outward normals and descent to foot points.
#pragma once

#include "occ/foot/surface_evaluator.h"
#include "occ/foot/trim_region.h"
#include "occ/kernel_points.h"

#include <GeomAbs_Shape.hxx>
#include <Geom_Surface.hxx>
#include <TopoDS_Face.hxx>

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace patchwright::occ {

/// Const functions are thread-safe.
class FaceSurface {
  public:
    /// A local minimum of the distance, on the surface within the rectangle around the face.
    struct Foot {
        Vec2 uv = Vec2::Zero();
        geom::Vec3 point = geom::Vec3::Zero();
        geom::Vec3 normal = geom::Vec3::Zero();  ///< as `normal(uv)`
        double distance = 0.0;
        /// Where the descent was held by the rectangle (u, v): -1 low end, 1 high end, 0 neither.
        std::array<int, 2> held{0, 0};
        /// Given up on the way to a foot that is known already: point and normal are none.
        bool merged = false;
    };

    /// @param size  length that tolerances are relative to: the model's diagonal
    /// @param memory  where the surface is kept: must outlive this
    /// @pre every edge of `face` has a p-curve
    FaceSurface(const TopoDS_Face& face, double size,
                std::pmr::memory_resource* memory = std::pmr::new_delete_resource());

    /// Neither trimmed nor of finite extent: nothing can be found on it.
    [[nodiscard]] bool unbounded() const { return unbounded_; }
    [[nodiscard]] const Vec2& low() const { return low_; }
    [[nodiscard]] const Vec2& high() const { return high_; }

    [[nodiscard]] geom::Vec3 at(const Vec2& uv) const;
    /// Principal curvatures and their directions.
    struct PrincipalCurvature {
        /// 1/mm, least first; positive where the surface bends towards its outward normal.
        std::array<double, 2> value{0.0, 0.0};
        std::array<geom::Vec3, 2> direction{geom::Vec3::Zero(), geom::Vec3::Zero()};  ///< unit
    };
    /// Nothing where the surface is degenerate.
    [[nodiscard]] std::optional<PrincipalCurvature> curvature(const Vec2& uv) const;
    /// Unit, outward. At degenerate points the limit, if it is one; else zero.
    [[nodiscard]] geom::Vec3 normal(const Vec2& uv) const;
    /// +1 when du x dv points outward, else -1.
    [[nodiscard]] double orientation() const { return orientation_; }
    [[nodiscard]] bool contains(const Vec2& uv) const;

    /// The surface is not smooth everywhere inside the rectangle around the face.
    [[nodiscard]] bool has_kinks() const { return !kinks_[0].empty() || !kinks_[1].empty(); }

    struct Rectangle {
        Vec2 low, high;
        bool operator==(const Rectangle&) const = default;
    };
    /// Calls `visit` with the part in `box` of every span of the surface that `box` reaches into.
    /// Within a span the surface is infinitely smooth; from one to the next its shape may change.
    template <class Visit>
    void each_span(const Rectangle& box, Visit&& visit) const {
        Rectangle span;
        each_interval(0, box, span, [&] { each_interval(1, box, span, [&] { visit(span); }); });
    }

    struct Start {
        Vec2 uv;
        double stride;  ///< millimetres; much longer steps may leap over a minimum
    };
    /// Newton's method on the squared distance with the rectangle as bound. Stops early when the
    /// path leads to one of the `known` feet of this face.
    [[nodiscard]] Foot descend(const geom::Vec3& query, const Start& start,
                               const std::vector<Vec2>& known) const;

  private:
    using Derivatives = SurfaceDerivatives;
    struct Step {
        double du, dv;
        bool newton;  ///< of second order: the Hessian was positive definite
    };
    /// Numbers one by one: written so and read as a pair they would be waited for.
    struct ParameterPair {
        double u, v;
        [[nodiscard]] Vec2 uv() const { return {u, v}; }
        [[nodiscard]] ParameterPair after(const Step& s, double fraction) const {
            return {u + fraction * s.du, v + fraction * s.dv};
        }
    };

    void set_rectangle();
    [[nodiscard]] std::array<std::vector<double>, 2> breaks(GeomAbs_Shape continuity) const;
    template <class Visit>
    void each_interval(std::size_t i, const Rectangle& box, Rectangle& span, Visit&& visit) const {
        const auto k = Eigen::Index(i);
        double low = box.low[k];
        for (const double knot : knots_[i]) {
            if (knot <= low || knot >= box.high[k]) continue;
            span.low[k] = low;
            span.high[k] = low = knot;
            visit();
        }
        span.low[k] = low;
        span.high[k] = box.high[k];
        visit();
    }
    [[nodiscard]] Derivatives derivatives(const Vec2& uv) const {
        return evaluator_->derivatives(uv);
    }
    [[nodiscard]] std::optional<Foot> closed_form_foot(const geom::Vec3& query,
                                                       const std::vector<Vec2>& known) const;
    [[nodiscard]] geom::Vec3 normal_of(const geom::Vec3& du, const geom::Vec3& dv,
                                       const Vec2& uv) const;
    [[nodiscard]] geom::Vec3 limit_normal(const Vec2& uv, bool flat_u, bool flat_v) const;
    [[nodiscard]] Rectangle cell_of(const Vec2& uv) const;
    [[nodiscard]] static Step step(const DistanceTerms& d, const ParameterPair& at,
                                   const Rectangle& cell);
    /// Which bounds of the cell hold the foot.
    void note_held(Foot& foot, const Rectangle& cell) const;
    [[nodiscard]] Foot descend_in(const Rectangle& cell, const geom::Vec3& query,
                                  const Start& start, const std::vector<Vec2>& known) const;
    [[nodiscard]] Foot descend_in_any(const Rectangle& cell, const geom::Vec3& query,
                                      const Start& start, const std::vector<Vec2>& known) const;
    [[nodiscard]] Foot descend_in_fused(const Rectangle& cell, const geom::Vec3& query,
                                        const Start& start, const std::vector<Vec2>& known) const;

    // What every descent asks for comes first: with many faces, each line of the cache counts.
    std::shared_ptr<const SurfaceEvaluator> evaluator_;
    Vec2 low_, high_;
    double orientation_ = 1.0;
    double size_;
    std::array<std::vector<double>, 2> kinks_;  ///< parameters where the surface is not smooth
    std::array<bool, 2> wraps_{false, false};   ///< u, v may run around the whole period
    bool unbounded_ = false;
    std::array<double, 2> period_{0.0, 0.0};
    TrimRegion trim_;
    Handle(Geom_Surface) surface_;
    std::array<std::vector<double>, 2> knots_;  ///< parameters where any derivative jumps
};

}  // namespace patchwright::occ
