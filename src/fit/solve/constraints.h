// What a step of the fit must leave alone.
#pragma once

#include <patchwright/geom/types.h>
#include <patchwright/subd/normal_control.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace patchwright::fit {

/// Control points may be held in single coordinates, or follow another one.
struct PointConstraints {
    static constexpr std::uint8_t all = 7;

    std::vector<std::uint8_t> held;  ///< by vertex: bit c for coordinate c
    /// A control point next to `leader`, which is on a plane, in the two coordinates that are not
    /// `axis`: at the leader, but for a share of the way to `other`. No leader or other follows.
    struct Follower {
        int vertex, leader, other;
        double share = 0.0;
    };
    /// So that the surface meets the plane at right angles.
    std::vector<Follower> followers;
    int axis = 0;
    const subd::CornerSectors* corners = nullptr;  ///< parts of these are kept

    /// Adds each follower's part to what it follows, and takes it away there: the transpose of
    /// `follow`.
    void gather(geom::Points& rows) const {
        for (const auto& [v, leader, other, share] : followers) {
            for (int c = 0; c < 3; ++c) {
                if (c == axis) continue;
                rows(leader, c) += (1.0 - share) * rows(v, c);
                rows(other, c) += share * rows(v, c);
                rows(v, c) = 0.0;
            }
        }
    }
    /// The displacements of all control points from those of free ones.
    void complete(geom::Points& rows) const {
        if (corners != nullptr) corners->project(rows);
        follow(rows);
    }
    /// The transpose of complete().
    void complete_transposed(geom::Points& rows) const {
        gather(rows);
        if (corners != nullptr) corners->project_transposed(rows);
    }
    void follow(geom::Points& rows) const {
        for (const auto& [v, leader, other, share] : followers) {
            for (int c = 0; c < 3; ++c) {
                if (c != axis)
                    rows(v, c) = (1.0 - share) * rows(leader, c) + share * rows(other, c);
            }
        }
    }
};

}  // namespace patchwright::fit
