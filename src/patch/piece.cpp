#include "patch/piece.h"

#include <algorithm>
#include <cmath>

namespace patchwright::patch {

namespace {

using geom::Points;
using subd::RingKind;

/// Coefficients of the blossom at (r, s, t) over the four uniform control points of segment [0, 1].
Eigen::Vector4d uniform_weights(double r, double s, double t) {
    Eigen::Vector4d w = Eigen::Vector4d::Zero();
    const double b[2] = {1.0 - t, t};
    const double a[3] = {b[0] * (1.0 - s) / 2.0, b[0] * (1.0 + s) / 2.0 + b[1] * (2.0 - s) / 2.0,
                         b[1] * s / 2.0};
    for (int i = 0; i < 3; ++i) {
        w[i] += a[i] * (1.0 + i - r) / 3.0;
        w[i + 1] += a[i] * (r + 2.0 - i) / 3.0;
    }
    return w;
}

Eigen::Vector4d bezier_weights(double r, double s, double t) {
    const double x = 1.0 - r, y = 1.0 - s, z = 1.0 - t;
    return {x * y * z, r * y * z + x * s * z + x * y * t, r * s * z + r * y * t + x * s * t,
            r * s * t};
}

struct Square {
    double u0 = 0.0, v0 = 0.0;
    int level = 0;

    [[nodiscard]] double size() const { return std::ldexp(1.0, -level); }
    [[nodiscard]] Square child(int i) const {
        const double half = 0.5 * size();
        return {u0 + (subd::at_end_u(i) ? half : 0.0), v0 + (subd::at_end_v(i) ? half : 0.0),
                level + 1};
    }
};

void collect_splits(const RingKind& kind, const Square& square, Splits& found) {
    if (classify(kind).shape != FaceShape::Other) return;
    found.u.push_back(square.u0 + 0.5 * square.size());
    found.v.push_back(square.v0 + 0.5 * square.size());
    for (int i = 0; i < 4; ++i) collect_splits(*kind.child(i).kind, square.child(i), found);
}

void collect_pieces(const RingKind& kind, const Points& local, const Square& square,
                    const std::array<int, 4>& hole, std::vector<PolynomialPiece>& pieces) {
    if (kind.is_regular()) {
        pieces.push_back({square.u0, square.v0, square.size(), PolynomialPiece::Basis::Uniform,
                          kind.regular() * local});
        return;
    }
    const FaceClass c = classify(kind);
    if (c.shape == FaceShape::OneCorner && square.level == hole[std::size_t(c.corner)]) return;
    for (int i = 0; i < 4; ++i) {
        const RingKind::Child& child = kind.child(i);
        collect_pieces(*child.kind, child.matrix.apply(local), square.child(i), hole, pieces);
    }
}

void sort_unique(std::vector<double>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

Eigen::RowVector3d PolynomialPiece::blossom(const Eigen::Vector3d& u,
                                            const Eigen::Vector3d& v) const {
    const Eigen::Vector3d r = (u.array() - u0) / size;
    const Eigen::Vector3d s = (v.array() - v0) / size;
    const auto weights = basis == Basis::Uniform ? uniform_weights : bezier_weights;
    const Eigen::Vector4d wu = weights(r[0], r[1], r[2]);
    const Eigen::Vector4d wv = weights(s[0], s[1], s[2]);
    Eigen::RowVector3d p = Eigen::RowVector3d::Zero();
    for (int i = 0; i < 4; ++i) p += wu[i] * (wv.transpose() * control.middleRows<4>(4 * i));
    return p;
}

PolynomialPiece seen_from(const PolynomialPiece& piece, int i) {
    if (i == 0) return piece;
    PolynomialPiece turned = piece;
    const double far_u = 1.0 - piece.u0 - piece.size;
    const double far_v = 1.0 - piece.v0 - piece.size;
    turned.u0 = i == 1 ? piece.v0 : i == 2 ? far_u : far_v;
    turned.v0 = i == 1 ? far_u : i == 2 ? far_v : piece.u0;
    for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
            const int row = i == 1   ? 4 * (3 - b) + a
                            : i == 2 ? 4 * (3 - a) + (3 - b)
                                     : 4 * b + (3 - a);
            turned.control.row(4 * a + b) = piece.control.row(row);
        }
    }
    return turned;
}

FaceClass classify(const RingKind& kind) {
    if (kind.is_regular()) return {FaceShape::Regular, -1};
    int corner = -1;
    for (int i = 0; i < 4; ++i) {
        const RingKind& child = *kind.child(i).kind;
        if (child.is_regular()) continue;
        if (corner >= 0 || &child != &kind) return {FaceShape::Other, -1};
        corner = i;
    }
    return {corner < 0 ? FaceShape::Other : FaceShape::OneCorner, corner};
}

int steps_to_one_corner(const RingKind& kind, int i) {
    int steps = 0;
    const RingKind* at = &kind;
    for (FaceClass c = classify(*at); c.shape != FaceShape::OneCorner || c.corner != i;
         c = classify(*at)) {
        at = at->child(i).kind;
        ++steps;
    }
    return steps;
}

Splits splits(const RingKind& kind) {
    Splits found;
    collect_splits(kind, {}, found);
    sort_unique(found.u);
    sort_unique(found.v);
    return found;
}

std::vector<PolynomialPiece> regular_pieces(const subd::Ring& ring, const Points& points,
                                            const std::array<int, 4>& hole) {
    std::vector<PolynomialPiece> pieces;
    collect_pieces(*ring.kind, gather(ring, points), {}, hole, pieces);
    return pieces;
}

Points gather(const subd::Ring& ring, const Points& points) {
    Points local(Eigen::Index(ring.vertices.size()), 3);
    for (std::size_t k = 0; k < ring.vertices.size(); ++k) {
        local.row(Eigen::Index(k)) = points.row(ring.vertices[k]);
    }
    return local;
}

}  // namespace patchwright::patch
