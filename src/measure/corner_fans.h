// Surfaces all around a common corner that do not cross near it.
#pragma once

#include "measure/surface_pieces.h"

#include <array>
#include <memory>
#include <vector>

namespace patchwright::measure {

/// Of each span of each surface, the fans that it belongs to, by corner of the surface; -1: none.
/// Two spans of one fan do not meet but where they touch.
class CornerFans {
  public:
    /// Looks at corners where at least three surfaces meet, all around. Takes time in proportion to
    /// their number, where their pairs would take its square.
    explicit CornerFans(const std::vector<std::unique_ptr<SurfacePieces>>& surfaces);

    [[nodiscard]] bool share_fan(int surface_a, int span_a, int surface_b, int span_b) const;

  private:
    using Fans = std::array<int, 4>;
    std::vector<std::vector<Fans>> fans_;
};

}  // namespace patchwright::measure
