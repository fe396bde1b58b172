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

  private:
    double major_, minor_;
};

/// The plane z = 0 inside the unit circle, whose rim is a free edge.
class Disc final : public geom::ReferenceSurface {
  public:
    Disc() { features_.curves.push_back({geom::FeatureKind::Free, 2 * M_PI, true}); }
    geom::Box3 bounds() const override { return {geom::Vec3(-1, -1, 0), geom::Vec3(1, 1, 0)}; }
    geom::FootPoint foot_point(const geom::Vec3& q,
                               const std::optional<geom::Vec3>&) const override {
        geom::Vec3 p(q.x(), q.y(), 0);
        if (p.norm() > 1) p.normalize();
        return {p, geom::Vec3::UnitZ(), (q - p).norm(), 0};
    }
    const geom::Features& features() const override { return features_; }
    geom::FeaturePoint nearest_on_curve(
        int, const geom::Vec3& q, const std::optional<geom::ArcRange>& within) const override {
        double angle = std::atan2(q.y(), q.x());
        if (within) {
            while (angle < within->from) angle += 2 * M_PI;
            if (angle > within->to) {
                const double beyond = angle - within->to;
                angle = beyond < within->from + 2 * M_PI - angle ? within->to : within->from;
            }
        }
        geom::FeaturePoint hit = point_on_curve(0, angle);
        hit.distance = (hit.point - q).norm();
        return hit;
    }
    geom::FeaturePoint point_on_curve(int, double s) const override {
        return {geom::Vec3(std::cos(s), std::sin(s), 0), 0.0, 0, s,
                geom::Vec3(-std::sin(s), std::cos(s), 0)};
    }

  private:
    geom::Features features_;
};

/// A shape whose feature curves are straight.
class StraightEdged : public geom::ReferenceSurface {
  public:
    const geom::Features& features() const override { return features_; }
    geom::FeaturePoint nearest_on_curve(
        int curve, const geom::Vec3& q,
        const std::optional<geom::ArcRange>& within) const override {
        const geom::FeatureCurve& c = features_.curves[std::size_t(curve)];
        const double s = std::clamp((q - c.start).dot((c.end - c.start) / c.length),
                                    within ? within->from : 0.0, within ? within->to : c.length);
        geom::FeaturePoint hit = point_on_curve(curve, s);
        hit.distance = (hit.point - q).norm();
        return hit;
    }
    geom::FeaturePoint point_on_curve(int curve, double s) const override {
        const geom::FeatureCurve& c = features_.curves[std::size_t(curve)];
        const geom::Vec3 tangent = (c.end - c.start) / c.length;
        return {c.start + s * tangent, 0.0, curve, s, tangent};
    }

  protected:
    geom::Features features_;
};

/// A box around the origin with its 12 sharp edges and 8 corners. Corner i is at (i & 1, i >> 1 &
/// 1, i >> 2) * 2 - 1, times the half sizes.
class Box : public StraightEdged {
  public:
    explicit Box(const geom::Vec3& half = geom::Vec3::Ones()) : half_(half) {
        features_.corners.resize(8);
        for (int i = 0; i < 8; ++i) {
            features_.corners[std::size_t(i)].point = half.cwiseProduct(
                geom::Vec3(2 * (i & 1) - 1, 2 * (i >> 1 & 1) - 1, 2 * (i >> 2) - 1));
        }
        for (int i = 0; i < 8; ++i) {
            for (int axis = 0; axis < 3; ++axis) {
                if ((i >> axis & 1) != 0) continue;
                const int curve = static_cast<int>(features_.curves.size());
                geom::FeatureCurve edge;
                edge.length = 2 * half[axis];
                edge.start_corner = i;
                edge.end_corner = i | 1 << axis;
                for (const int c : {edge.start_corner, edge.end_corner})
                    features_.corners[std::size_t(c)].curves.push_back(curve);
                edge.start = features_.corners[std::size_t(i)].point;
                edge.end = features_.corners[std::size_t(edge.end_corner)].point;
                features_.curves.push_back(edge);
            }
        }
    }
    geom::Box3 bounds() const override { return {-half_, half_}; }
    geom::FootPoint foot_point(const geom::Vec3& q,
                               const std::optional<geom::Vec3>&) const override {
        geom::Vec3 p = q.cwiseMax(-half_).cwiseMin(half_);
        int axis = 0;
        (half_ - p.cwiseAbs()).minCoeff(&axis);
        p[axis] = std::copysign(half_[axis], p[axis]);
        return {p, geom::Vec3::Unit(axis) * std::copysign(1.0, p[axis]), (q - p).norm(), axis};
    }

  private:
    geom::Vec3 half_;
};

}  // namespace patchwright::test
