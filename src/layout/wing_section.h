// Trailing edge, nose and sides of a wing's section.
#pragma once

#include "layout/sections.h"

#include <patchwright/occ/cad_reference.h>

#include <array>
#include <optional>

namespace patchwright::layout {

/// A section between its trailing edge and its nose. Sides run from the trailing edge to the nose
/// and from the nose to the trailing edge, as the loop does.
struct WingSection {
    std::array<std::vector<geom::Vec3>, 2> sides;  ///< both hold the nose
    bool blunt = false;                            ///< the trailing edge has two edges
    double chord = 0.0;
    double thickness = 0.0;
    double nose_radius = 0.0;

    [[nodiscard]] const geom::Vec3& nose() const { return sides[1].front(); }
    [[nodiscard]] geom::Vec3 trailing_edge() const {
        return 0.5 * (sides[0].front() + sides[1].back());
    }
    /// Point of a side at this share of its length, from the trailing edge.
    [[nodiscard]] geom::Vec3 at(int side, double share) const;
    [[nodiscard]] double length(int side) const;
};

/// Nothing when the lines are not one thin closed loop with one sharp edge, or two near each other.
std::optional<WingSection> wing_section(const std::vector<SectionLoop>& loops,
                                        const geom::Features& features,
                                        const geom::ModelSurface& reference);

}  // namespace patchwright::layout
