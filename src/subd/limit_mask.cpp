#include <patchwright/base/error.h>
#include <patchwright/subd/limit_mask.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::subd {

namespace {

/// Uniform cubic B-spline basis at t in [0, 1]: values, first and second derivatives in columns.
Eigen::Matrix<double, 4, 3> uniform_basis(double t) {
    const double s = 1.0 - t;
    Eigen::Matrix<double, 4, 3> b;
    b << s * s * s / 6.0, -0.5 * s * s, s,                                          //
        (4.0 + t * t * (3.0 * t - 6.0)) / 6.0, t * (1.5 * t - 2.0), 3.0 * t - 2.0,  //
        (4.0 + s * s * (3.0 * s - 6.0)) / 6.0, s * (2.0 - 1.5 * s), 3.0 * s - 2.0,  //
        t * t * t / 6.0, 0.5 * t * t, t;
    return b;
}

constexpr int row_count(int order) { return order == 0 ? 1 : order == 1 ? 3 : 6; }

/// How often each row of a mask is differentiated along u and v.
constexpr int derivatives[6][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};

Eigen::MatrixXd regular_rows(const RingKind& kind, double u, double v, int order) {
    const auto bu = uniform_basis(u);
    const auto bv = uniform_basis(v);
    Eigen::Matrix<double, Eigen::Dynamic, 16, 0, 6, 16> basis(row_count(order), 16);
    for (int row = 0; row < basis.rows(); ++row) {
        for (int a = 0; a < 4; ++a) {
            basis.row(row).segment<4>(4 * a) =
                bu(a, derivatives[row][0]) * bv.col(derivatives[row][1]).transpose();
        }
    }
    return basis * kind.regular();
}

/// The corner of the unit square that (u, v) is nearest to.
int nearest_corner(double u, double v) { return v > 0.5 ? (u > 0.5 ? 2 : 3) : (u > 0.5 ? 1 : 0); }

/// Parameters of the child times 2^levels are those of the face.
void scale_derivatives(Eigen::MatrixXd& rows, int levels) {
    for (Eigen::Index row = 1; row < rows.rows(); ++row) {
        rows.row(row) *= std::ldexp(1.0, levels * (row < 3 ? 1 : 2));
    }
}

RingMask corner_mask(const RingKind::Corner& corner, int order) {
    RingMask mask;
    mask.rows = Eigen::MatrixXd::Zero(row_count(order), corner.limit.size());
    mask.rows.row(0) = corner.limit;
    mask.smoothness = corner.eigenvalue > 0.0 ? Smoothness::TangentPlane : Smoothness::Position;
    if (order > 0) mask.rows.middleRows<2>(1) = corner.tangents;
    return mask;
}

}  // namespace

RingMask ring_mask(const RingKind& kind, double u, double v, int sector, int order) {
    if (kind.is_regular()) return {regular_rows(kind, u, v, order), Smoothness::Derivatives};
    if (kind.size() != 4) {
        // A sector's parameters are its own: nothing to scale.
        const RingKind::Child& child = kind.child(sector);
        RingMask mask = ring_mask(*child.kind, u, v, 0, order);
        mask.rows *= child.matrix;
        return mask;
    }
    const int i = nearest_corner(u, v);
    // Distances from the corner are exact: 1 - u is for u >= 1/2.
    double away_u = at_end_u(i) ? 1.0 - u : u;
    double away_v = at_end_v(i) ? 1.0 - v : v;
    const double away = std::max(away_u, away_v);
    const auto square = [&](double distance, bool end) { return end ? 1.0 - distance : distance; };
    if (kind.is_stationary(i)) {
        if (away == 0.0) return corner_mask(kind.corner(i), order);
        int levels = 0;
        std::frexp(away, &levels);  // away = m 2^levels with m in [1/2, 1)
        levels = -levels;
        if (levels > 0) {
            const double scale = std::ldexp(1.0, levels);
            away_u *= scale;
            away_v *= scale;
            RingMask mask =
                ring_mask(kind, square(away_u, at_end_u(i)), square(away_v, at_end_v(i)), 0, order);
            for (int bit = 0; levels >> bit != 0; ++bit) {
                if ((levels >> bit & 1) != 0) mask.rows *= kind.contraction_power(i, bit);
            }
            mask.rows.row(0) += kind.corner(i).limit;
            scale_derivatives(mask.rows, levels);
            return mask;
        }
    }
    const RingKind::Child& child = kind.child(i);
    RingMask mask = ring_mask(*child.kind, square(2.0 * away_u, at_end_u(i)),
                              square(2.0 * away_v, at_end_v(i)), 0, order);
    mask.rows *= child.matrix;
    scale_derivatives(mask.rows, 1);
    return mask;
}

LimitEvaluator::LimitEvaluator(std::shared_ptr<const mesh::Topology> topology)
    : topology_(std::move(topology)), table_(std::make_unique<RingTable>()) {}

Mask LimitEvaluator::mask(const Location& at, int order) const {
    if (!at.face.valid() || at.face.value >= topology_->face_count()) {
        throw base::InvalidArgument(fmt::format("face {} does not exist; there are {}",
                                                at.face.value, topology_->face_count()));
    }
    const int sectors = topology_->size(at.face) == 4 ? 1 : topology_->size(at.face);
    if (!(at.u >= 0.0 && at.u <= 1.0 && at.v >= 0.0 && at.v <= 1.0) || at.sector < 0 ||
        at.sector >= sectors) {
        throw base::InvalidArgument(
            fmt::format("face {}: parameters ({}, {}) of sector {} are not on it", at.face.value,
                        at.u, at.v, at.sector));
    }
    if (order < 0 || order > 2) throw base::InvalidArgument("masks have order 0, 1 or 2");
    const Ring ring = table_->ring(*topology_, at.face);
    const RingMask local = ring_mask(*ring.kind, at.u, at.v, at.sector, order);
    Mask mask;
    mask.smoothness = local.smoothness;
    mask.vertices = ring.vertices;
    std::sort(mask.vertices.begin(), mask.vertices.end());
    mask.vertices.erase(std::unique(mask.vertices.begin(), mask.vertices.end()),
                        mask.vertices.end());
    mask.rows = Eigen::MatrixXd::Zero(local.rows.rows(), Eigen::Index(mask.vertices.size()));
    for (std::size_t slot = 0; slot < ring.vertices.size(); ++slot) {
        const auto column =
            std::lower_bound(mask.vertices.begin(), mask.vertices.end(), ring.vertices[slot]) -
            mask.vertices.begin();
        mask.rows.col(column) += local.rows.col(Eigen::Index(slot));
    }
    return mask;
}

geom::Vec3 LimitEvaluator::position(const geom::Points& points, const Location& at) const {
    const Mask m = mask(at);
    geom::Vec3 sum = geom::Vec3::Zero();
    for (std::size_t k = 0; k < m.vertices.size(); ++k) {
        sum += m.rows(0, Eigen::Index(k)) * points.row(m.vertices[k]).transpose();
    }
    return sum;
}

LimitPoint LimitEvaluator::evaluate(const geom::Points& points, const Location& at) const {
    const Mask m = mask(at, 2);
    Eigen::Matrix<double, 6, 3> values = Eigen::Matrix<double, 6, 3>::Zero();
    for (std::size_t k = 0; k < m.vertices.size(); ++k) {
        values += m.rows.col(Eigen::Index(k)) * points.row(m.vertices[k]);
    }
    LimitPoint point{values.row(0),
                     values.row(1),
                     values.row(2),
                     values.row(3),
                     values.row(4),
                     values.row(5),
                     {},
                     m.smoothness};
    point.normal = point.du.cross(point.dv);
    const double size = point.normal.norm();
    point.normal = size > 0.0 ? geom::Vec3(point.normal / size) : geom::Vec3::Zero();
    return point;
}

geom::Vec3 limit_position(const mesh::Cage& cage, mesh::VertexId v) {
    const mesh::Topology& t = *cage.topology;
    const mesh::CornerId c = t.corner(v);
    const mesh::FaceId f = t.face(c);
    const int i = c.value - t.corners(f)[0].value;
    Location at{f, 0.0, 0.0, 0};
    if (t.size(f) == 4) {
        at.u = i == 1 || i == 2 ? 1.0 : 0.0;
        at.v = i >= 2 ? 1.0 : 0.0;
    } else {
        at.sector = i;
    }
    return LimitEvaluator(cage.topology).position(cage.points, at);
}

}  // namespace patchwright::subd
