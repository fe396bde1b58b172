#include "fit/solve/mesh_preconditioner.h"

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <utility>

namespace patchwright::fit {

using geom::Points;
using mesh::CornerId;
using mesh::Topology;
using mesh::VertexId;

namespace {

constexpr std::size_t vertices_a_task = 8192;

/// to = block * from; they may be the same.
void times(const MeshPreconditioner::Block& b, const double* from, double* to) {
    const double x = from[0], y = from[1], z = from[2];
    to[0] = b[0] * x + b[3] * y + b[4] * z;
    to[1] = b[3] * x + b[1] * y + b[5] * z;
    to[2] = b[4] * x + b[5] * y + b[2] * z;
}

bool is_quad(const Topology& t, CornerId c) { return c.valid() && t.size(t.face(c)) == 4; }

}  // namespace

MeshPreconditioner::MeshPreconditioner(const Topology& t, double a)
    : a_(a), rings_(std::size_t(t.vertex_count())) {
    base::parallel_for(rings_.size(), vertices_a_task, [&](std::size_t first, std::size_t last) {
        for (std::size_t v = first; v < last; ++v) {
            Neighbours& ring = rings_[v];
            std::size_t quads = 0;
            const CornerId start = t.corner(VertexId{static_cast<std::int32_t>(v)});
            CornerId c = start;
            do {
                if (quads == 4 || !is_quad(t, c)) {
                    quads = 5;
                    break;
                }
                const CornerId next = t.next(c);
                ring[quads] = t.vertex(next).value;
                ring[4 + quads] = t.vertex(t.next(next)).value;
                ++quads;
                c = t.rotate(c);
            } while (c.valid() && c != start);
            if (quads != 4 || c != start) ring[0] = -1;
        }
    });
    for (std::size_t v = 0; v < rings_.size(); ++v) {
        if (rings_[v][0] >= 0) continue;
        const VertexId vertex{static_cast<std::int32_t>(v)};
        const std::size_t begin = irregular_.size();
        irregular_.push_back({vertex.value, 1.0F, 0.0F, 0.0F});
        const auto add_edge = [&](VertexId end, int quads) {
            irregular_.push_back({end.value, 0.0F, -1.0F, static_cast<float>(-quads)});
            irregular_[begin].edges += 1.0F;
        };
        const CornerId start = t.corner(vertex);
        CornerId c = start;
        for (;;) {
            const CornerId next = t.next(c), twin = t.twin(c);
            add_edge(t.vertex(next), int(is_quad(t, c)) + int(is_quad(t, twin)));
            if (is_quad(t, c)) {
                irregular_.push_back({t.vertex(t.next(next)).value, 0.0F, 0.0F, 1.0F});
                irregular_[begin].quads += 1.0F;
            }
            const CornerId further = t.rotate(c);
            if (!further.valid()) {
                add_edge(t.vertex(t.previous(c)), int(is_quad(t, c)));
                break;
            }
            if (further == start) break;
            c = further;
        }
        rings_[v][1] = static_cast<std::int32_t>(begin);
        rings_[v][2] = static_cast<std::int32_t>(irregular_.size());
    }
}

void MeshPreconditioner::set(double a, std::vector<Block> blocks) {
    a_ = a;
    blocks_ = std::move(blocks);
}

template <class Row>
void MeshPreconditioner::products(const Points& x, std::size_t first, std::size_t last,
                                  const Row& row) const {
    const double centre = (1 + 2 * a_) * (1 + 2 * a_), edge = -a_ * (1 + 2 * a_), far = a_ * a_;
    for (std::size_t v = first; v < last; ++v) {
        const Neighbours& ring = rings_[v];
        double sum[3];
        if (ring[0] >= 0) {
            const double* p[8];
            for (std::size_t i = 0; i < 8; ++i) p[i] = x.data() + 3 * std::ptrdiff_t(ring[i]);
            const double* own = x.data() + 3 * std::ptrdiff_t(v);
            for (int c = 0; c < 3; ++c) {
                sum[c] = centre * own[c] + edge * ((p[0][c] + p[1][c]) + (p[2][c] + p[3][c])) +
                         far * ((p[4][c] + p[5][c]) + (p[6][c] + p[7][c]));
            }
        } else {
            std::fill(sum, sum + 3, 0.0);
            for (auto i = ring[1]; i < ring[2]; ++i) {
                const IrregularWeight& other = irregular_[std::size_t(i)];
                const double weight = other.fixed + a_ * other.edges + a_ * a_ * other.quads;
                for (int c = 0; c < 3; ++c) {
                    sum[c] += weight * x.data()[3 * std::ptrdiff_t(other.vertex) + c];
                }
            }
        }
        row(v, sum);
    }
}

Eigen::Array3d MeshPreconditioner::apply_transposed(const Points& s, Points& t) const {
    t.resize(s.rows(), 3);
    if (!blocks_.empty()) {
        turned_.resize(s.rows(), 3);
        base::parallel_for(rings_.size(), vertices_a_task,
                           [&](std::size_t first, std::size_t last) {
                               for (std::size_t v = first; v < last; ++v) {
                                   times(blocks_[v], s.data() + 3 * v, turned_.data() + 3 * v);
                               }
                           });
    }
    const Points& from = blocks_.empty() ? s : turned_;
    std::vector<Eigen::Array3d> partial((rings_.size() + vertices_a_task - 1) / vertices_a_task);
    base::parallel_for(rings_.size(), vertices_a_task, [&](std::size_t first, std::size_t last) {
        Eigen::Array3d norms = Eigen::Array3d::Zero();
        products(from, first, last, [&](std::size_t v, const double* sum) {
            double* to = t.data() + 3 * v;
            for (int c = 0; c < 3; ++c) {
                to[c] = sum[c];
                norms[c] += sum[c] * sum[c];
            }
        });
        partial[first / vertices_a_task] = norms;
    });
    Eigen::Array3d all = Eigen::Array3d::Zero();
    for (const Eigen::Array3d& part : partial) all += part;
    return all;
}

void MeshPreconditioner::apply(const Points& t, const Eigen::Array3d& beta, Points& d) const {
    base::parallel_for(rings_.size(), vertices_a_task, [&](std::size_t first, std::size_t last) {
        products(t, first, last, [&](std::size_t v, double* sum) {
            double* to = d.data() + 3 * v;
            if (!blocks_.empty()) times(blocks_[v], sum, sum);
            for (int c = 0; c < 3; ++c) to[c] = sum[c] + beta[c] * to[c];
        });
    });
}

}  // namespace patchwright::fit
