#include "measure/piece_meeting.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace patchwright::measure {

using geom::Vec3;

namespace {

/// Steps towards a plane that parts two control nets, each beyond the worst pair by half of what
/// brings it onto the plane (Agmon, The relaxation method for linear inequalities, 1954).
constexpr int plane_steps = 12;
constexpr double relaxation = 1.5;

bool parts_nets(const BezierPiece& a, const BezierPiece& b, Vec3 normal, int most_steps,
                double slack_mm) {
    for (int step = 0; step < most_steps; ++step) {
        const double length = normal.norm();
        if (!(length > 0.0)) return false;
        normal /= length;
        Eigen::Index last = 0, first = 0;
        const double end = (a.net * normal).maxCoeff(&last);
        const double begin = (b.net * normal).minCoeff(&first);
        if (begin - end > -slack_mm) return true;
        const Vec3 between = (b.net.row(first) - a.net.row(last)).transpose();
        normal += relaxation * (end - begin) / between.squaredNorm() * between;
    }
    return false;
}

}  // namespace

bool are_apart(const BezierPiece& a, const BezierPiece& b, double slack_mm) {
    const Vec3 between = (b.net.colwise().mean() - a.net.colwise().mean()).transpose();
    if (parts_nets(a, b, between, plane_steps, slack_mm)) return true;
    for (const BezierPiece* piece : {&a, &b}) {
        const auto& net = piece->net;
        Vec3 along_u = Vec3::Zero(), along_v = Vec3::Zero();
        for (Eigen::Index k = 0; k < 4; ++k) {
            along_u += (net.row(12 + k) - net.row(k)).transpose();
            along_v += (net.row(4 * k + 3) - net.row(4 * k)).transpose();
        }
        const Vec3 normal = along_u.cross(along_v);
        if (parts_nets(a, b, normal, 1, slack_mm) || parts_nets(a, b, -normal, 1, slack_mm))
            return true;
    }
    return false;
}

std::optional<PieceMeeting> meeting_point(const BezierPiece& a, const BezierPiece& b,
                                          double exact_mm) {
    constexpr int most_steps = 8;
    constexpr double astray = 3.0;  // from the middle, where steps lead elsewhere
    Eigen::Vector4d at = Eigen::Vector4d::Constant(0.5);
    for (int step = 0; step < most_steps; ++step) {
        const auto p = a.at(at[0], at[1]), q = b.at(at[2], at[3]);
        const Vec3 gap = p.position - q.position;
        if (gap.norm() <= exact_mm) {
            if ((at.array() < 0.0).any() || (at.array() > 1.0).any()) return std::nullopt;
            const auto place = [](const Extent& e, double s, double t) {
                return Eigen::Vector2d(e.u[0] + s * (e.u[1] - e.u[0]),
                                       e.v[0] + t * (e.v[1] - e.v[0]));
            };
            return PieceMeeting{p.position, {place(a, at[0], at[1]), place(b, at[2], at[3])}};
        }
        Eigen::Matrix<double, 3, 4> jacobian;
        jacobian << p.du, p.dv, -q.du, -q.dv;
        Eigen::Matrix3d normal = jacobian * jacobian.transpose();
        // Keeps it regular where the pieces are parallel.
        normal.diagonal().array() += 1e-12 * normal.trace();
        at -= jacobian.transpose() * (normal.inverse() * gap);
        if (!((at.array() - 0.5).abs() < astray).all()) return std::nullopt;
    }
    return std::nullopt;
}

bool stays_near(const geom::BsplineSurface& surface, const Vec3& point, const Eigen::Vector2d& from,
                const Eigen::Vector2d& to, double reach_mm) {
    constexpr int parts = 8;
    for (int k = 1; k <= parts; ++k) {
        const Eigen::Vector2d uv = from + (to - from) * k / parts;
        if ((surface.at(uv[0], uv[1]).position - point).norm() > reach_mm) return false;
    }
    return true;
}

bool is_beside_side(const geom::BsplineSurface& surface, const Vec3& point,
                    const Eigen::Vector2d& uv, double reach_mm) {
    const auto reaches = [&](double u, double v) {
        return stays_near(surface, point, uv, {u, v}, reach_mm);
    };
    return reaches(surface.knots_u.front(), uv[1]) || reaches(surface.knots_u.back(), uv[1]) ||
           reaches(uv[0], surface.knots_v.front()) || reaches(uv[0], surface.knots_v.back());
}

}  // namespace patchwright::measure
