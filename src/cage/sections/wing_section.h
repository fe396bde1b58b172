// Trailing edge, nose and sides of a wing's section.
#pragma once

#include "cage/sections/sections.h"

#include <patchwright/geom/model_surface.h>

#include <array>
#include <optional>
#include <set>
#include <string>

namespace patchwright::cage {

/// Curves of the model that run along a wing, by their numbers.
struct WingLines {
    std::set<int> tail;    ///< sharp; both edges of a blunt trailing edge
    std::set<int> nose;    ///< sharp at least in parts
    std::set<int> around;  ///< sharp or bent, in the plane of a section
};

/// A section between its trailing edge and its nose. Sides run from the trailing edge to the nose
/// and from the nose to the trailing edge, as the loop does.
struct WingSection {
    std::array<std::vector<geom::Vec3>, 2> sides;  ///< both hold the nose
    bool blunt = false;                            ///< the trailing edge has two edges
    bool faded = false;         ///< no sharp line here: the trailing edge is where it would go on
    bool nose_on_line = false;  ///< a curve of the nose crosses here
    double chord = 0.0;
    double thickness = 0.0;
    double nose_radius = 0.0;
    geom::Vec3 center = geom::Vec3::Zero();  ///< of the line's length

    [[nodiscard]] const geom::Vec3& nose() const { return sides[1].front(); }
    [[nodiscard]] geom::Vec3 trailing_edge() const {
        return 0.5 * (sides[0].front() + sides[1].back());
    }
    [[nodiscard]] bool thin() const;
    /// Makes a sharp trailing edge a blunt one of a thousandth of the chord.
    void open_tail();
    /// Point of a side at this share of its length, from the trailing edge.
    [[nodiscard]] geom::Vec3 at(int side, double share) const;
    [[nodiscard]] double length(int side) const;
};

/// The curves at the wedge of a thin section: the same one twice where it is sharp. Nothing when
/// the lines are not one closed loop with such a wedge.
std::optional<std::array<int, 2>> tail_curves(const std::vector<SectionLoop>& loops,
                                              const geom::ModelSurface& reference);

/// Sharp curves but those of the tail that cross the section near its nose.
std::set<int> nose_curves(const std::vector<SectionLoop>& loops, const std::set<int>& tail,
                          const geom::ModelSurface& reference);

/// A section, or why there is none.
struct SectionResult {
    std::optional<WingSection> section;
    std::string why;
};

/// @param like  a section nearby: where no curve of the tail crosses the section, its trailing edge
///              is looked for in the same place; without it there is no section then
SectionResult wing_section(const std::vector<SectionLoop>& loops, const WingLines& lines,
                           const geom::ModelSurface& reference, const WingSection* like = nullptr);

}  // namespace patchwright::cage
