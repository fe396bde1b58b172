#include <patchwright/base/error.h>
#include <patchwright/subd/limit_mask.h>

#include <fmt/format.h>

namespace patchwright::subd {

namespace {

/// Uniform cubic B-spline basis and its derivative at t in [0, 1].
struct UniformBasis {
    Eigen::Vector4d value, derivative;
};

UniformBasis uniform_basis(double t) {
    const double s = 1.0 - t;
    UniformBasis b;
    b.value << s * s * s, 4.0 + t * t * (3.0 * t - 6.0), 4.0 + s * s * (3.0 * s - 6.0), t * t * t;
    b.value /= 6.0;
    b.derivative << -0.5 * s * s, t * (1.5 * t - 2.0), s * (2.0 - 1.5 * s), 0.5 * t * t;
    return b;
}

Eigen::RowVectorXd tensor_row(const Eigen::Vector4d& bu, const Eigen::Vector4d& bv,
                              const Eigen::MatrixXd& regular) {
    Eigen::Matrix<double, 1, 16> basis;
    for (int a = 0; a < 4; ++a) basis.segment<4>(4 * a) = bu[a] * bv.transpose();
    return basis * regular;
}

/// The corner of the unit square that (u, v) is, or -1.
int square_corner(double u, double v) {
    if (u == 0.0) return v == 0.0 ? 0 : v == 1.0 ? 3 : -1;
    if (u == 1.0) return v == 0.0 ? 1 : v == 1.0 ? 2 : -1;
    return -1;
}

}  // namespace

RingMask ring_mask(const RingKind& kind, double u, double v, int sector) {
    if (kind.is_regular()) {
        const UniformBasis bu = uniform_basis(u);
        const UniformBasis bv = uniform_basis(v);
        return {tensor_row(bu.value, bv.value, kind.regular()),
                tensor_row(bu.derivative, bv.value, kind.regular()),
                tensor_row(bu.value, bv.derivative, kind.regular())};
    }
    if (kind.size() != 4) {
        const RingKind::Child& child = kind.child(sector);
        const RingMask fine = ring_mask(*child.kind, u, v);
        return {fine.position * child.matrix, fine.du * child.matrix, fine.dv * child.matrix};
    }
    if (const int corner = square_corner(u, v); corner >= 0) {
        const Eigen::RowVectorXd none = Eigen::RowVectorXd::Zero(kind.slots());
        return {kind.corner_limit(corner), none, none};
    }
    const bool right = u > 0.5;
    const bool upper = v > 0.5;
    const int i = upper ? (right ? 2 : 3) : (right ? 1 : 0);
    const RingKind::Child& child = kind.child(i);
    const RingMask fine =
        ring_mask(*child.kind, 2.0 * u - (right ? 1.0 : 0.0), 2.0 * v - (upper ? 1.0 : 0.0));
    return {fine.position * child.matrix, 2.0 * fine.du * child.matrix,
            2.0 * fine.dv * child.matrix};
}

LimitEvaluator::LimitEvaluator(std::shared_ptr<const mesh::Topology> topology)
    : topology_(std::move(topology)), table_(std::make_unique<RingTable>()) {}

Mask LimitEvaluator::position_mask(const Location& at) const {
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
    Ring ring = table_->ring(*topology_, at.face);
    const RingMask mask = ring_mask(*ring.kind, at.u, at.v, at.sector);
    return {std::move(ring.vertices),
            {mask.position.data(), mask.position.data() + mask.position.size()}};
}

geom::Vec3 LimitEvaluator::position(const geom::Points& points, const Location& at) const {
    const Mask mask = position_mask(at);
    geom::Vec3 sum = geom::Vec3::Zero();
    for (std::size_t k = 0; k < mask.vertices.size(); ++k) {
        sum += mask.weights[k] * points.row(mask.vertices[k]).transpose();
    }
    return sum;
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
