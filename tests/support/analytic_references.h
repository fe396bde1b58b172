// Shapes with closed-form foot points.
#pragma once

#include <patchwright/geom/reference_surface.h>

#include <algorithm>
#include <cmath>

namespace patchwright::test {

class Sphere final : public geom::ReferenceSurface {
  public:
    explicit Sphere(double radius) : radius_(radius) {}
    geom::Box3 bounds() const override {
        return {geom::Vec3::Constant(-radius_), geom::Vec3::Constant(radius_)};
    }
    geom::FootPoint foot_point(const geom::Vec3& q,
                               const std::optional<geom::Vec3>&) const override {
        const geom::Vec3 n = q.normalized();
        return {radius_ * n, n, std::abs(q.norm() - radius_), 0};
    }
    std::optional<geom::FeaturePoint> feature_point(const geom::Vec3&,
                                                    geom::FeatureKind) const override {
        return std::nullopt;
    }

  private:
    double radius_;
};

/// Around the z axis.
class Torus final : public geom::ReferenceSurface {
  public:
    Torus(double major, double minor) : major_(major), minor_(minor) {}
    geom::Box3 bounds() const override {
        const geom::Vec3 half(major_ + minor_, major_ + minor_, minor_);
        return {-half, half};
    }
    geom::FootPoint foot_point(const geom::Vec3& q,
                               const std::optional<geom::Vec3>&) const override {
        const geom::Vec3 ring = major_ * geom::Vec3(q.x(), q.y(), 0).normalized();
        const geom::Vec3 n = (q - ring).normalized();
        return {ring + minor_ * n, n, std::abs((q - ring).norm() - minor_), 0};
    }
    std::optional<geom::FeaturePoint> feature_point(const geom::Vec3&,
                                                    geom::FeatureKind) const override {
        return std::nullopt;
    }

  private:
    double major_, minor_;
};

/// The plane z = 0 inside the unit circle, whose rim is a free edge.
class Disc final : public geom::ReferenceSurface {
  public:
    geom::Box3 bounds() const override { return {geom::Vec3(-1, -1, 0), geom::Vec3(1, 1, 0)}; }
    geom::FootPoint foot_point(const geom::Vec3& q,
                               const std::optional<geom::Vec3>&) const override {
        geom::Vec3 p(q.x(), q.y(), 0);
        if (p.norm() > 1) p.normalize();
        return {p, geom::Vec3::UnitZ(), (q - p).norm(), 0};
    }
    std::optional<geom::FeaturePoint> feature_point(const geom::Vec3& q,
                                                    geom::FeatureKind kind) const override {
        if (kind != geom::FeatureKind::Free) return std::nullopt;
        const geom::Vec3 p = geom::Vec3(q.x(), q.y(), 0).normalized();
        return geom::FeaturePoint{p, (q - p).norm(), 0, 0.0, geom::Vec3(-p.y(), p.x(), 0)};
    }
};

/// The surface of the cube [-1, 1]^3 with its 12 sharp edges and 8 corners.
class Box final : public geom::ReferenceSurface {
  public:
    geom::Box3 bounds() const override {
        return {geom::Vec3::Constant(-1), geom::Vec3::Constant(1)};
    }
    geom::FootPoint foot_point(const geom::Vec3& q,
                               const std::optional<geom::Vec3>&) const override {
        geom::Vec3 p = q.cwiseMax(-1).cwiseMin(1);
        int axis = 0;
        p.cwiseAbs().maxCoeff(&axis);
        p[axis] = std::copysign(1.0, p[axis]);
        return {p, geom::Vec3::Unit(axis) * p[axis], (q - p).norm(), axis};
    }
    std::optional<geom::FeaturePoint> feature_point(const geom::Vec3& q,
                                                    geom::FeatureKind kind) const override {
        if (kind == geom::FeatureKind::Free || kind == geom::FeatureKind::Smooth)
            return std::nullopt;
        geom::Vec3 p = q.cwiseMax(-1).cwiseMin(1);
        int inner = 0;
        p.cwiseAbs().minCoeff(&inner);
        for (int axis = 0; axis < 3; ++axis) {
            if (axis != inner || kind == geom::FeatureKind::Corner)
                p[axis] = std::copysign(1.0, q[axis]);
        }
        const bool corner = kind == geom::FeatureKind::Corner;
        const geom::Vec3 tangent = corner ? geom::Vec3::Zero().eval() : geom::Vec3::Unit(inner);
        return geom::FeaturePoint{p, (q - p).norm(), 0, 0.0, tangent};
    }
};

}  // namespace patchwright::test
