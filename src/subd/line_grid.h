// The control points of a regular face near parabolic runouts.
#pragma once

#include <patchwright/mesh/topology.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace patchwright::subd {

/// Vertices around a face at places (a, b) from 0 to 3, a along u; the face's own are (1, 1),
/// (2, 1), (2, 2), (1, 2). Those beyond the face's creases are missing.
class LineGrid {
  public:
    /// @pre topology.is_near_runout(face)
    LineGrid(const mesh::Topology& topology, mesh::FaceId face);

    /// The face's own in order, then the others.
    [[nodiscard]] std::vector<std::int32_t> vertices() const;
    /// Equal for grids with equal control_points(), and for no ring's key.
    [[nodiscard]] std::string key() const;
    /// 16 x vertices, as RingKind::regular(): lines end naturally, and each end that follows the
    /// rule adds its difference to that. Where such ends of both directions meet, at corners, the
    /// product of their differences is left out; it is of the order of the approximation's error.
    [[nodiscard]] Eigen::MatrixXd control_points() const;

  private:
    enum Direction { U, V };

    /// Where the lines of one direction end, low or high.
    struct End {
        bool crease = false;           ///< at the face's own side; else one face farther, if at all
        std::array<bool, 4> runout{};  ///< by place of the line
    };

    void find_cells(mesh::CornerId own);
    [[nodiscard]] mesh::CornerId& cell(int i, int j) { return cells_[std::size_t(3 * i + j + 4)]; }
    [[nodiscard]] const mesh::CornerId& cell(int i, int j) const {
        return cells_[std::size_t(3 * i + j + 4)];
    }
    [[nodiscard]] std::int32_t& vertex(int a, int b) { return vertex_[std::size_t(4 * a + b)]; }
    [[nodiscard]] std::int32_t vertex(int a, int b) const {
        return vertex_[std::size_t(4 * a + b)];
    }
    [[nodiscard]] std::int32_t find_vertex(int a, int b) const;
    [[nodiscard]] bool has_runout(Direction along, int at, int towards, int line) const;

    [[nodiscard]] const End& end(Direction along, int side) const {
        return ends_[std::size_t(2 * along + side)];
    }
    [[nodiscard]] End& end(Direction along, int side) {
        return ends_[std::size_t(2 * along + side)];
    }
    /// First and last place of lines, 0 to 3.
    [[nodiscard]] int place(Direction along, int side) const {
        const int inner = end(along, side).crease ? 1 : 0;
        return side == 0 ? inner : 3 - inner;
    }

    const mesh::Topology& topology_;
    std::array<mesh::CornerId, 9> cells_;  // -1 to 1, the face's own at (0, 0)
    std::array<std::int32_t, 16> vertex_;  // -1: missing
    std::array<End, 4> ends_;              // U low, U high, V low, V high
};

}  // namespace patchwright::subd
