// Where the points of a wing's sections and tips are.
#pragma once

#include "cage/sections/wing_section.h"

#include <utility>
#include <vector>

namespace patchwright::cage {

/// The points of a ring, numbered from the trailing edge over the first side to the nose, and back
/// over the second one.
struct RingColumns {
    int of_side;           ///< points of either side, without one on the nose's line
    bool blunt, has_nose;  ///< whether the sides part at the trailing edge, meet on the nose's line

    [[nodiscard]] int size() const { return 2 * of_side - (blunt ? 0 : 1) + (has_nose ? 1 : 0); }
    [[nodiscard]] bool on_nose(int j) const { return has_nose && j == of_side; }
    [[nodiscard]] bool is_tail(int j) const { return j == 0 || (blunt && across(j) == 0); }
    /// The point across, on the other side; itself at a sharp trailing edge and on the nose's line.
    [[nodiscard]] int across(int j) const { return blunt ? size() - 1 - j : (size() - j) % size(); }
    [[nodiscard]] std::pair<int, int> side_and_column(int j) const {
        const int second = 2 * of_side - (has_nose ? 0 : 1);
        return j < of_side ? std::pair(0, j) : std::pair(1, second - j);
    }
};

/// The same shares of the sides' lengths in all rings, from the trailing edge: dense at the nose;
/// where no line runs on it, its points lie where the section has turned by about 50 degrees.
/// @pre there are sections
std::vector<double> column_shares(const std::vector<WingSection>& sections, int columns);

/// How far a body goes on from a point inside, at most to the end of a way from there.
/// @return millimetres along the way
double way_out(const geom::Vec3& from, const geom::Vec3& way, const geom::ModelSurface& reference);

}  // namespace patchwright::cage
