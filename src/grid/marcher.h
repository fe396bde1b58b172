// How layers of a volume grid are grown off a front.
#pragma once

#include "grid/front.h"

#include <span>
#include <vector>

namespace patchwright::grid {

/// Of a layer's height: shorter steps would be rounding.
constexpr double shortest_step = 1e-6;

/// Marches one front to the next.
class Marcher {
  public:
    explicit Marcher(const FrontMesh& mesh);

    /// @param heights    that the layer is to have, mm, one a point
    /// @param smoothing  sweeps over the directions
    /// @param shares     set: of the heights that steps have; lengths along what sees all cells
    ///                   count in full
    /// @return the next front
    geom::Points march(const geom::Points& from, const std::vector<double>& heights, int smoothing,
                       std::vector<double>& shares);

  private:
    /// Of a front: normals of cells at their corners, and the best directions.
    void look_around(const geom::Points& front);
    /// Of the cells around a point.
    [[nodiscard]] std::span<const geom::Vec3> normals(std::size_t p) const;
    [[nodiscard]] geom::Vec3 in_plane(std::size_t p, const geom::Vec3& v) const;
    [[nodiscard]] double sight(std::size_t p, const geom::Vec3& direction) const;

    /// The direction whose worst angle with the cells' normals is least, nearly; the one that the
    /// point came from, which sees all of them, where the search finds none that does.
    [[nodiscard]] geom::Vec3 best_direction(const geom::Points& points, std::size_t p) const;
    [[nodiscard]] geom::Vec3 searched_direction(std::size_t p) const;
    [[nodiscard]] geom::Vec3 mean_around(const std::vector<geom::Vec3>& values,
                                         std::size_t p) const;
    void smooth_directions(int sweeps);

    /// Spreads points of the new front, where steps are long beside cells.
    void even_out(const geom::Points& from, const std::vector<double>& heights, int sweeps);

    /// Least scaled Jacobian at the point of the cells that stand on a front.
    [[nodiscard]] double least_below(const geom::Points& from, std::size_t p,
                                     const geom::Vec3& step) const;
    /// The same of their corners on the new front.
    [[nodiscard]] double least_above(const geom::Points& from, std::size_t p) const;

    /// Whether a cell has a corner at the point that is thinner than it may be. A new front is as
    /// good for the next step as it is for this one; so with short enough steps there always is one
    /// that is not bad, however many layers there are.
    [[nodiscard]] bool is_bad(const geom::Points& from, std::size_t p) const;

    /// Whether a point or one beside it is marked.
    [[nodiscard]] bool is_near(const std::vector<char>& marks, std::size_t p) const;

    /// Shortens steps and makes them more alike until no cell is too thin.
    void repair(const geom::Points& from, const std::vector<double>& heights);

    const FrontMesh& mesh_;
    std::vector<geom::Vec3> steps_, other_;
    std::vector<geom::Vec3> came_;     ///< directions of the last steps; zero before the first
    std::vector<geom::Vec3> normals_;  ///< of cells at their corners, unit
    std::vector<geom::Vec3> best_;     ///< directions
    std::vector<double> limits_;       ///< of the scaled Jacobian on new fronts
    std::vector<char> bad_, moved_, hopeless_;
};

}  // namespace patchwright::grid
