// How far the cells of a surface grid are from the shapes that they are to have.
#pragma once

#include "grid/front.h"

#include <array>
#include <functional>
#include <vector>

namespace patchwright::grid {

/// Of one cell's corner: the sides that leave it, as they are to be.
struct WantedCorner {
    double next_mm = 1.0, previous_mm = 1.0;  ///< lengths
    double cosine = 0.0, sine = 1.0;          ///< of the angle between them
};

/// The cells of a grid with the shapes wanted.
class SmoothCells {
  public:
    struct Cell {
        std::array<std::int32_t, 4> points;  ///< counter-clockwise
        /// Per corner, whose normal it is measured by: one a side of the features at a point.
        std::array<std::int32_t, 4> normals;
        std::array<WantedCorner, 4> wanted;
        std::array<bool, 4> folded{};  ///< or nearly: may stay so
    };

    /// @param is_feature  of the grid's lines: two points' numbers, on one block edge
    SmoothCells(const Plan& plan, const FrontMesh& mesh,
                const std::function<bool(std::int32_t, std::int32_t)>& is_feature);

    [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }
    [[nodiscard]] std::size_t point_count() const { return point_count_; }

    /// Normals of every corner's surroundings, from the cells as they are, where folded ones count
    /// against others; and which corners are folded. From then on the energy of others has no bound
    /// towards a fold.
    void measure_normals(const geom::Points& points);
    /// Of each point: one of its normals; that of all its corners away from features.
    [[nodiscard]] geom::Points point_normals() const;

    /// What is minimised, of every cell alone.
    void energies(const geom::Points& points, std::vector<double>& result) const;

    /// Directions that a point can go; zero those that it cannot.
    using Basis = Eigen::Matrix<double, 3, 2>;
    /// Of one cell's energy by its points' parameters along their bases, two a point.
    struct Derivatives {
        Eigen::Matrix<double, 8, 1> first;
        Eigen::Matrix<double, 8, 8>
            second;  ///< the part that is never negative, as Gauss and Newton
    };
    [[nodiscard]] Derivatives derivatives(std::size_t cell, const geom::Points& points,
                                          const std::vector<Basis>& bases) const;

  private:
    void collect(const Plan& plan, const FrontMesh& mesh);
    void part_normals(const std::function<bool(std::int32_t, std::int32_t)>& is_feature);
    void want_lengths(const geom::Points& points);
    void want_angles(const geom::Points& points);
    /// Whether cells lie all around the point.
    [[nodiscard]] bool is_inside(std::size_t p) const;

    std::size_t point_count_ = 0;
    std::vector<Cell> cells_;
    std::vector<geom::Vec3> normals_;
    std::vector<std::size_t> begin_;     ///< of a point's corners
    std::vector<std::int32_t> corners_;  ///< 4 cell + corner
};

}  // namespace patchwright::grid
