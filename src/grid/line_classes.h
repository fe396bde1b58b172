// Which edges of blocks must have equally many points.
#pragma once

#include <patchwright/grid/layout.h>

namespace patchwright::grid {

/// Edges that the lines of blocks connect.
struct LineClasses {
    struct Member {
        int line_class = -1;
        bool reversed = false;  ///< the edge runs against the first edge of its class
    };
    std::vector<Member> edges;
    /// Per class, whether its lines come back the other way round, so that first and last are one.
    std::vector<char> mirrored;

    [[nodiscard]] int count() const { return static_cast<int>(mirrored.size()); }
};

LineClasses line_classes(const BlockLayout& layout);

}  // namespace patchwright::grid
