#include "patch/cap_limit.h"

#include <Eigen/Geometry>
#include <array>

namespace patchwright::patch {

using geom::Points;

namespace {

constexpr std::array<double, 5> fit_shares{0.04, 0.2, 0.4, 0.6, 0.8};
constexpr std::array<double, 6> check_shares{0.02, 0.12, 0.3, 0.5, 0.7, 0.9};

/// Of a corner's parameters (s along the edge that leaves it, t along the one that arrives) those
/// of the face.
Eigen::Vector2d face_parameters(int corner, double s, double t) {
    switch (corner) {
        case 0: return {s, t};
        case 1: return {1.0 - t, s};
        case 2: return {1.0 - s, 1.0 - t};
        default: return {t, 1.0 - s};
    }
}

}  // namespace

std::span<const double> shares_of(Samples samples) {
    if (samples == Samples::Fit) return fit_shares;
    return check_shares;
}

const Eigen::MatrixXd& LimitSampler::masks_of(const subd::RingKind& kind, int corner,
                                              Samples samples, Value value) {
    const std::lock_guard lock(mutex_);
    Eigen::MatrixXd& masks = masks_[{&kind, corner, samples, value}];
    if (masks.size() != 0) return masks;
    const std::span<const double> shares = shares_of(samples);
    masks.resize(Eigen::Index(shares.size() * shares.size()), kind.slots());
    const int order = value == Value::Position ? 0 : 1;
    Eigen::Index row = 0;
    for (const double s : shares) {
        for (const double t : shares) {
            const Eigen::Vector2d uv = face_parameters(corner, s, t);
            masks.row(row++) =
                subd::ring_mask(kind, uv.x(), uv.y(), 0, order).rows.row(Eigen::Index(value));
        }
    }
    return masks;
}

Points LimitSampler::points(const subd::RingKind& kind, int corner, const Points& ring,
                            Samples samples) {
    return masks_of(kind, corner, samples, Value::Position) * ring;
}

Points LimitSampler::normals(const subd::RingKind& kind, int corner, const Points& ring,
                             Samples samples) {
    const Points du = masks_of(kind, corner, samples, Value::AlongU) * ring;
    const Points dv = masks_of(kind, corner, samples, Value::AlongV) * ring;
    Points normals(du.rows(), 3);
    for (Eigen::Index k = 0; k < du.rows(); ++k) {
        const Eigen::RowVector3d u = du.row(k), v = dv.row(k);
        normals.row(k) = u.cross(v).normalized();
    }
    return normals;
}

}  // namespace patchwright::patch
