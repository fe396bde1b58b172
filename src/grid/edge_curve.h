// Curves along the edges of blocks, and lengths along them.
#pragma once

#include <patchwright/grid/layout.h>
#include <patchwright/subd/limit_mask.h>

#include <functional>
#include <vector>

namespace patchwright::grid {

/// The limit curve over a run of half-edges; the k-th has the parameters [k, k + 1].
class EdgeCurve {
  public:
    /// @pre the arguments outlive this
    EdgeCurve(const subd::LimitEvaluator& limit, const mesh::Cage& cage, const BlockEdge& edge)
        : limit_(limit), cage_(cage), edge_(edge) {}

    [[nodiscard]] double end() const { return double(edge_.run.size()); }
    [[nodiscard]] geom::Vec3 at(double t) const;
    struct Derivatives {
        geom::Vec3 point, first, second;
    };
    [[nodiscard]] Derivatives derivatives(double t) const;
    /// Parameters between which the curve is smooth enough for a few integration points.
    [[nodiscard]] std::vector<double> breaks() const;

  private:
    [[nodiscard]] subd::LimitPoint evaluate(double t, int order, int& side) const;

    const subd::LimitEvaluator& limit_;
    const mesh::Cage& cage_;
    const BlockEdge& edge_;
};

/// The integral of a positive function from the first break, and its inverse.
class Cumulative {
  public:
    Cumulative(std::function<double(double)> f, std::vector<double> breaks);

    [[nodiscard]] double total() const { return sums_.back(); }
    [[nodiscard]] double at(double t) const;
    /// The t with at(t) == value.
    [[nodiscard]] double inverse(double value) const;

  private:
    [[nodiscard]] double piece(double from, double to) const;

    std::function<double(double)> f_;
    std::vector<double> breaks_, sums_;
};

}  // namespace patchwright::grid
