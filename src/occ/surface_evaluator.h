// Evaluation of the surfaces under faces without the kernel, where their kind allows it.
#pragma once

#include "kernel_points.h"

#include <Geom_Surface.hxx>

#include <memory>
#include <optional>

namespace patchwright::occ {

struct SurfaceDerivatives {
    geom::Vec3 p, u, v, uu, uv, vv;
};

struct SurfaceTangents {
    geom::Vec3 p, u, v;
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
    [[nodiscard]] virtual geom::Vec3 at(const Vec2& uv) const { return derivatives(uv).p; }
    /// Where the untrimmed surface is nearest to `query`, for kinds with a closed form; angles lie
    /// in (-pi, pi]. Nothing for the others, and where many points are equally near.
    [[nodiscard]] virtual std::optional<Vec2> nearest(const geom::Vec3&) const {
        return std::nullopt;
    }
};

/// Planes, cylinders, cones, spheres and tori in closed form, Bezier and B-spline surfaces span by
/// span as polynomials, revolutions and extrusions by their profile; the rest by the kernel.
std::shared_ptr<const SurfaceEvaluator> make_evaluator(const Handle(Geom_Surface) & surface);

}  // namespace patchwright::occ
