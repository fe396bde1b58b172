#include "occ/foot/surface_evaluator.h"

#include "occ/foot/spline_spans.h"

#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <gp_Ax3.hxx>

#include <Eigen/Geometry>
#include <cmath>

namespace patchwright::occ {

using geom::Vec3;

namespace {

class KernelSurface final : public SurfaceEvaluator {
  public:
    explicit KernelSurface(Handle(Geom_Surface) surface) : surface_(std::move(surface)) {}
    SurfaceDerivatives derivatives(const Vec2& uv) const override {
        gp_Pnt p;
        gp_Vec du, dv, duu, dvv, duv;
        surface_->D2(uv[0], uv[1], p, du, dv, duu, dvv, duv);
        return {vec(p), vec(du), vec(dv), vec(duu), vec(duv), vec(dvv)};
    }
    Vec3 at(const Vec2& uv) const override {
        gp_Pnt p;
        surface_->D0(uv[0], uv[1], p);
        return vec(p);
    }

  private:
    Handle(Geom_Surface) surface_;
};

/// Axes that need not be right-handed.
struct SurfaceAxes {
    Vec3 origin, x, y, z;

    explicit SurfaceAxes(const gp_Ax3& axes)
        : origin(vec(axes.Location())),
          x(vec(axes.XDirection().XYZ())),
          y(vec(axes.YDirection().XYZ())),
          z(vec(axes.Direction().XYZ())) {}
};

class PlaneSurface final : public SurfaceEvaluator {
  public:
    explicit PlaneSurface(const gp_Ax3& axes) : frame_(axes) {}
    SurfaceDerivatives derivatives(const Vec2& uv) const override {
        const Vec3 zero = Vec3::Zero();
        return {at(uv), frame_.x, frame_.y, zero, zero, zero};
    }
    Vec3 at(const Vec2& uv) const override {
        return frame_.origin + uv[0] * frame_.x + uv[1] * frame_.y;
    }
    std::optional<Vec2> nearest(const Vec3& query) const override {
        const Vec3 r = query - frame_.origin;
        return Vec2(r.dot(frame_.x), r.dot(frame_.y));
    }

  private:
    SurfaceAxes frame_;
};

/// Radius and height of a profile with derivatives.
struct ProfilePoint {
    double r, z, dr, dz, ddr, ddz;
};

struct CylinderProfile {
    double radius;
    [[nodiscard]] ProfilePoint at(double v) const { return {radius, v, 0, 1, 0, 0}; }
    [[nodiscard]] std::optional<double> nearest(double, double z) const { return z; }
};

struct ConeProfile {
    double radius, sine, cosine;
    [[nodiscard]] ProfilePoint at(double v) const {
        return {radius + v * sine, v * cosine, sine, cosine, 0, 0};
    }
    [[nodiscard]] std::optional<double> nearest(double r, double z) const {
        const double v = (r - radius) * sine + z * cosine;
        // Beyond the apex the other half of the profile may be nearer.
        if (radius + v * sine <= 0.0) return std::nullopt;
        return v;
    }
};

struct SphereProfile {
    double radius;
    [[nodiscard]] ProfilePoint at(double v) const {
        const double c = radius * std::cos(v), s = radius * std::sin(v);
        return {c, s, -s, c, -c, -s};
    }
    [[nodiscard]] std::optional<double> nearest(double r, double z) const {
        if (r * r + z * z <= 1e-20 * radius * radius) return std::nullopt;
        return std::atan2(z, r);
    }
};

struct TorusProfile {
    double major, minor;
    [[nodiscard]] ProfilePoint at(double v) const {
        const double c = minor * std::cos(v), s = minor * std::sin(v);
        return {major + c, s, -s, c, -c, -s};
    }
    [[nodiscard]] std::optional<double> nearest(double r, double z) const {
        if (minor >= major || std::hypot(r - major, z) <= 1e-10 * minor) return std::nullopt;
        return std::atan2(z, r - major);
    }
};

template <class Profile>
class RoundSurface final : public SurfaceEvaluator {
  public:
    RoundSurface(const gp_Ax3& axes, const Profile& profile) : frame_(axes), profile_(profile) {}
    SurfaceDerivatives derivatives(const Vec2& uv) const override {
        const double c = std::cos(uv[0]), s = std::sin(uv[0]);
        const Vec3 out = c * frame_.x + s * frame_.y, along = c * frame_.y - s * frame_.x;
        const ProfilePoint q = profile_.at(uv[1]);
        return {frame_.origin + q.r * out + q.z * frame_.z,
                q.r * along,
                q.dr * out + q.dz * frame_.z,
                -q.r * out,
                q.dr * along,
                q.ddr * out + q.ddz * frame_.z};
    }
    std::optional<Vec2> nearest(const Vec3& query) const override {
        const Vec3 r = query - frame_.origin;
        const double x = r.dot(frame_.x), y = r.dot(frame_.y), z = r.dot(frame_.z);
        const double radius = std::hypot(x, y);
        if (!(radius > 1e-10 * (std::abs(z) + profile_.at(0.0).r))) return std::nullopt;
        const auto v = profile_.nearest(radius, z);
        if (!v) return std::nullopt;
        return Vec2(std::atan2(y, x), *v);
    }

  private:
    SurfaceAxes frame_;
    Profile profile_;
};

struct CurvePoint {
    Vec3 p, d, dd;

    CurvePoint(const Geom_Curve& curve, double t) {
        gp_Pnt gp;
        gp_Vec gd, gdd;
        curve.D2(t, gp, gd, gdd);
        p = vec(gp);
        d = vec(gd);
        dd = vec(gdd);
    }
};

class RevolvedSurface final : public SurfaceEvaluator {
  public:
    explicit RevolvedSurface(const Geom_SurfaceOfRevolution& surface)
        : profile_(surface.BasisCurve()),
          origin_(vec(surface.Axis().Location())),
          axis_(vec(surface.Axis().Direction().XYZ())) {}
    SurfaceDerivatives derivatives(const Vec2& uv) const override {
        const double c = std::cos(uv[0]), s = std::sin(uv[0]);
        const CurvePoint q(*profile_, uv[1]);
        const Vec3 r = q.p - origin_;
        // Rotation splits a vector into what stays, what turns and what it turns towards.
        const auto turned = [&](const Vec3& w) {
            const Vec3 along = axis_ * axis_.dot(w);
            return Vec3(along + c * (w - along) + s * axis_.cross(w));
        };
        const auto turning = [&](const Vec3& w) {
            const Vec3 along = axis_ * axis_.dot(w);
            return Vec3(c * axis_.cross(w) - s * (w - along));
        };
        const Vec3 point = turned(r);
        return {origin_ + point, turning(r),  turned(q.d), axis_ * axis_.dot(point) - point,
                turning(q.d),    turned(q.dd)};
    }

  private:
    Handle(Geom_Curve) profile_;
    Vec3 origin_, axis_;
};

class ExtrudedSurface final : public SurfaceEvaluator {
  public:
    explicit ExtrudedSurface(const Geom_SurfaceOfLinearExtrusion& surface)
        : profile_(surface.BasisCurve()), direction_(vec(surface.Direction().XYZ())) {}
    SurfaceDerivatives derivatives(const Vec2& uv) const override {
        const CurvePoint q(*profile_, uv[0]);
        const Vec3 zero = Vec3::Zero();
        return {q.p + uv[1] * direction_, q.d, direction_, q.dd, zero, zero};
    }

  private:
    Handle(Geom_Curve) profile_;
    Vec3 direction_;
};

template <class Profile>
std::shared_ptr<const SurfaceEvaluator> round(const gp_Ax3& axes, const Profile& profile) {
    return std::make_shared<RoundSurface<Profile>>(axes, profile);
}

}  // namespace

std::shared_ptr<const SurfaceEvaluator> make_evaluator(const Handle(Geom_Surface) & surface,
                                                       std::pmr::memory_resource* memory) {
    if (const auto s = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface); !s.IsNull())
        return make_evaluator(s->BasisSurface(), memory);
    if (const auto s = Handle(Geom_Plane)::DownCast(surface); !s.IsNull())
        return std::make_shared<PlaneSurface>(s->Position());
    if (const auto s = Handle(Geom_CylindricalSurface)::DownCast(surface); !s.IsNull())
        return round(s->Position(), CylinderProfile{s->Radius()});
    if (const auto s = Handle(Geom_ConicalSurface)::DownCast(surface); !s.IsNull())
        return round(s->Position(), ConeProfile{s->RefRadius(), std::sin(s->SemiAngle()),
                                                std::cos(s->SemiAngle())});
    if (const auto s = Handle(Geom_SphericalSurface)::DownCast(surface); !s.IsNull())
        return round(s->Position(), SphereProfile{s->Radius()});
    if (const auto s = Handle(Geom_ToroidalSurface)::DownCast(surface); !s.IsNull())
        return round(s->Position(), TorusProfile{s->MajorRadius(), s->MinorRadius()});
    if (const auto s = Handle(Geom_SurfaceOfRevolution)::DownCast(surface); !s.IsNull())
        return std::make_shared<RevolvedSurface>(*s);
    if (const auto s = Handle(Geom_SurfaceOfLinearExtrusion)::DownCast(surface); !s.IsNull())
        return std::make_shared<ExtrudedSurface>(*s);
    if (auto spans = make_spline_spans(surface, memory)) return spans;
    return std::make_shared<KernelSurface>(surface);
}

}  // namespace patchwright::occ
