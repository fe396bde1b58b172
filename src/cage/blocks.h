// A part of a cage while it is put together.
#pragma once

#include <patchwright/geom/types.h>

#include <string>
#include <utility>
#include <vector>

namespace patchwright::cage {

struct Blocks {
    std::vector<geom::Vec3> points;       ///< on the model
    std::vector<std::vector<int>> faces;  ///< counter-clockwise seen from outside
    std::vector<std::string> groups;      ///< one a face
    std::vector<std::pair<int, int>> creases;
    std::vector<int> corners;
};

}  // namespace patchwright::cage
