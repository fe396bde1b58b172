#include "grid/limit_face.h"

#include <patchwright/subd/limit_mask.h>

namespace patchwright::grid {

namespace {

// Nearer to an extraordinary vertex than 2^-this masks are cheaper than more pieces.
constexpr int deepest = 14;

struct Basis {
    double value[4];
    explicit Basis(double t) {
        const double s = 1.0 - t;
        value[0] = s * s * s / 6.0;
        value[1] = (4.0 + t * t * (3.0 * t - 6.0)) / 6.0;
        value[2] = (4.0 + s * s * (3.0 * s - 6.0)) / 6.0;
        value[3] = t * t * t / 6.0;
    }
};

geom::Vec3 bicubic(const geom::Points& control, double u, double v) {
    const Basis bu(u), bv(v);
    const double* c = control.data();
    double x = 0.0, y = 0.0, z = 0.0;
    for (int a = 0; a < 4; ++a) {
        double row[3] = {0.0, 0.0, 0.0};
        for (int b = 0; b < 4; ++b, c += 3) {
            row[0] += bv.value[b] * c[0];
            row[1] += bv.value[b] * c[1];
            row[2] += bv.value[b] * c[2];
        }
        x += bu.value[a] * row[0];
        y += bu.value[a] * row[1];
        z += bu.value[a] * row[2];
    }
    return {x, y, z};
}

/// Derivatives of the basis.
Eigen::Vector4d slopes(double t) {
    const double s = 1.0 - t;
    return {-0.5 * s * s, t * (1.5 * t - 2.0), -s * (1.5 * s - 2.0), 0.5 * t * t};
}

geom::Vec3 combined(const geom::Points& control, const Eigen::Vector4d& along_u,
                    const Eigen::Vector4d& along_v) {
    geom::Vec3 sum = geom::Vec3::Zero();
    for (Eigen::Index a = 0; a < 4; ++a)
        for (Eigen::Index b = 0; b < 4; ++b)
            sum += along_u[a] * along_v[b] * control.row(4 * a + b).transpose();
    return sum;
}

}  // namespace

LimitFace::LimitFace(subd::RingTable& table, const mesh::Cage& cage, mesh::FaceId face) {
    const subd::Ring ring = table.ring(*cage.topology, face);
    geom::Points control(Eigen::Index(ring.vertices.size()), 3);
    for (std::size_t k = 0; k < ring.vertices.size(); ++k) {
        control.row(Eigen::Index(k)) = cage.points.row(ring.vertices[k]);
    }
    nodes_.push_back(make_node(*ring.kind, std::move(control)));
}

LimitFace::Node LimitFace::make_node(const subd::RingKind& kind, geom::Points control) const {
    Node node;
    node.kind = &kind;
    if (kind.is_regular()) {
        node.control = kind.regular() * control;
    } else {
        node.control = std::move(control);
    }
    return node;
}

LimitFace::Piece LimitFace::piece_at(double u, double v) {
    Piece piece{0, u, v, 1.0};
    for (int depth = 0;; ++depth) {
        if (nodes_[piece.node].kind->is_regular() || depth == deepest) return piece;
        if ((piece.u == 0.0 || piece.u == 1.0) && (piece.v == 0.0 || piece.v == 1.0)) return piece;
        const bool right = piece.u > 0.5, top = piece.v > 0.5;
        const int i = top ? (right ? 2 : 3) : (right ? 1 : 0);
        if (nodes_[piece.node].child[std::size_t(i)] < 0) {
            const subd::RingKind::Child& child = nodes_[piece.node].kind->child(i);
            Node next = make_node(*child.kind, child.matrix.apply(nodes_[piece.node].control));
            nodes_[piece.node].child[std::size_t(i)] = static_cast<std::int32_t>(nodes_.size());
            nodes_.push_back(std::move(next));
        }
        piece = {std::size_t(nodes_[piece.node].child[std::size_t(i)]),
                 2.0 * piece.u - (right ? 1.0 : 0.0), 2.0 * piece.v - (top ? 1.0 : 0.0),
                 2.0 * piece.scale};
    }
}

geom::Vec3 LimitFace::at(double u, double v) {
    const Piece piece = piece_at(u, v);
    const Node& node = nodes_[piece.node];
    if (node.kind->is_regular()) return bicubic(node.control, piece.u, piece.v);
    const subd::RingMask mask = subd::ring_mask(*node.kind, piece.u, piece.v);
    return (mask.rows.row(0) * node.control).transpose();
}

LimitFace::Tangents LimitFace::tangents(double u, double v) {
    const Piece piece = piece_at(u, v);
    const Node& node = nodes_[piece.node];
    Tangents result;
    if (node.kind->is_regular()) {
        const Eigen::Vector4d bu(Basis(piece.u).value), bv(Basis(piece.v).value);
        const Eigen::Vector4d du = slopes(piece.u), dv = slopes(piece.v);
        result = {combined(node.control, bu, bv), combined(node.control, du, bv),
                  combined(node.control, bu, dv)};
    } else {
        const subd::RingMask mask = subd::ring_mask(*node.kind, piece.u, piece.v, 0, 1);
        result = {(mask.rows.row(0) * node.control).transpose(),
                  (mask.rows.row(1) * node.control).transpose(),
                  (mask.rows.row(2) * node.control).transpose()};
    }
    result.du *= piece.scale;
    result.dv *= piece.scale;
    return result;
}

}  // namespace patchwright::grid
