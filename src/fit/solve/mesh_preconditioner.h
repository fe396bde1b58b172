// What makes solves for control points of a mesh take few steps.
#pragma once

#include "fit/solve/cgls.h"

#include <patchwright/mesh/topology.h>

#include <array>
#include <cstdint>
#include <vector>

namespace patchwright::fit {

/// x = B y with B = G K, K = 1 + a sum_e d_e d_e^T + a^2 sum_q m_q m_q^T, where d_e is the
/// difference of an edge's ends and m_q the mixed difference (1, -1, 1, -1) of a quad's corners.
/// Alternating displacements of control points have little effect on limit points; K scales them
/// up. On a regular grid K is (1 + a (2 - 2 cos s)) (1 + a (2 - 2 cos t)) for waves of angles s and
/// t, and a is such that the product of K^2 with the samples' normal matrix has the least
/// condition, 9.7 in place of 363 (4 samples a face; 9.3 and 344 for 16). Positive definite on
/// every mesh. G has a symmetric block a vertex, for problems in which coordinates are coupled.
class MeshPreconditioner final : public Preconditioner {
  public:
    static constexpr double mass = 0.82;  ///< the a for samples of points alone
    /// xx, yy, zz, xy, xz, yz.
    using Block = std::array<double, 6>;

    explicit MeshPreconditioner(const mesh::Topology& topology, double a = mass);
    /// @param blocks  one a vertex, positive definite; or none: G = 1
    void set(double a, std::vector<Block> blocks);

    [[nodiscard]] Eigen::Index size() const override { return Eigen::Index(rings_.size()); }
    Eigen::Array3d apply_transposed(const geom::Points& s, geom::Points& t) const override;
    void apply(const geom::Points& t, const Eigen::Array3d& beta, geom::Points& d) const override;

  private:
    /// Of a vertex with four quads around it: ends of its edges, then the quads' far corners. Of
    /// any other one: -1, and where its weights begin and end in irregular_.
    using Neighbours = std::array<std::int32_t, 8>;
    /// Weight of a vertex: fixed + a * edges + a^2 * quads.
    struct IrregularWeight {
        std::int32_t vertex;
        float fixed, edges, quads;
    };

    /// `row(v, K's product there)` for all vertices from `first` to `last`.
    template <class Row>
    void products(const geom::Points& x, std::size_t first, std::size_t last, const Row& row) const;

    double a_;
    std::vector<Neighbours> rings_;
    std::vector<IrregularWeight> irregular_;  // the vertex itself first
    std::vector<Block> blocks_;
    mutable geom::Points turned_;  // G s; spares its allocation
};

}  // namespace patchwright::fit
