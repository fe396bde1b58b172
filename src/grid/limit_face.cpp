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

geom::Vec3 LimitFace::at(double u, double v) {
    std::size_t n = 0;
    for (int depth = 0;; ++depth) {
        if (nodes_[n].kind->is_regular()) return bicubic(nodes_[n].control, u, v);
        const bool right = u > 0.5, top = v > 0.5;
        const int i = top ? (right ? 2 : 3) : (right ? 1 : 0);
        const bool at_corner = (u == 0.0 || u == 1.0) && (v == 0.0 || v == 1.0);
        if (depth == deepest || at_corner) {
            const subd::RingMask mask = subd::ring_mask(*nodes_[n].kind, u, v);
            return (mask.rows.row(0) * nodes_[n].control).transpose();
        }
        if (nodes_[n].child[std::size_t(i)] < 0) {
            const subd::RingKind::Child& child = nodes_[n].kind->child(i);
            Node next = make_node(*child.kind, child.matrix.apply(nodes_[n].control));
            nodes_[n].child[std::size_t(i)] = static_cast<std::int32_t>(nodes_.size());
            nodes_.push_back(std::move(next));
        }
        n = std::size_t(nodes_[n].child[std::size_t(i)]);
        u = 2.0 * u - (right ? 1.0 : 0.0);
        v = 2.0 * v - (top ? 1.0 : 0.0);
    }
}

}  // namespace patchwright::grid
