// Evaluation of the surfaces under faces without the kernel, where their kind allows it.
#pragma once

#include "occ/kernel_points.h"

#include <Geom_Surface.hxx>

#include <memory>
#include <memory_resource>
#include <optional>

namespace patchwright::occ {

struct SurfaceDerivatives {
    geom::Vec3 p, u, v, uu, uv, vv;
};

struct SurfaceTangents {
    geom::Vec3 p, u, v;
};

/// What Newton's method asks of half the squared distance to a query, with r = p - query: all that
/// is left of the derivatives, so that they need not leave the registers.
struct DistanceTerms {
    double rr, ru, rv;
    double uu, uv, vv;        ///< products of the tangents: the first fundamental form
    double r_uu, r_uv, r_vv;  ///< products of r and the second derivatives

    /// Of a step in the parameters, along the tangents.
    [[nodiscard]] double squared_length(double du, double dv) const {
        return uu * du * du + 2.0 * uv * du * dv + vv * dv * dv;
    }
};

/// Const functions are thread-safe.
class SurfaceEvaluator {
  public:
    virtual ~SurfaceEvaluator() = default;
    [[nodiscard]] virtual SurfaceDerivatives derivatives(const Vec2& uv) const = 0;
    [[nodiscard]] virtual SurfaceTangents tangents(const Vec2& uv) const {
        const SurfaceDerivatives d = derivatives(uv);
        return {d.p, d.u, d.v};
    }
    [[nodiscard]] virtual DistanceTerms distance_terms(const Vec2& uv,
                                                       const geom::Vec3& query) const {
        const SurfaceDerivatives d = derivatives(uv);
        const geom::Vec3 r = d.p - query;
        return {r.squaredNorm(),   r.dot(d.u),  r.dot(d.v),  d.u.squaredNorm(), d.u.dot(d.v),
                d.v.squaredNorm(), r.dot(d.uu), r.dot(d.uv), r.dot(d.vv)};
    }
    [[nodiscard]] virtual geom::Vec3 at(const Vec2& uv) const { return derivatives(uv).p; }
    /// Where the untrimmed surface is nearest to `query`, for kinds with a closed form; angles lie
    /// in (-pi, pi]. Nothing for the others, and where many points are equally near.
    [[nodiscard]] virtual std::optional<Vec2> nearest(const geom::Vec3&) const {
        return std::nullopt;
    }
};

/// Planes, cylinders, cones, spheres and tori in closed form, Bezier and B-spline surfaces span by
/// span as polynomials, revolutions and extrusions by their profile; the rest by the kernel.
/// @param memory  where splines are kept: must outlive the result
std::shared_ptr<const SurfaceEvaluator> make_evaluator(
    const Handle(Geom_Surface) & surface,
    std::pmr::memory_resource* memory = std::pmr::new_delete_resource());

}  // namespace patchwright::occ
