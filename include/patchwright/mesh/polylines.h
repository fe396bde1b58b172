// Control polygons of curves as Wavefront OBJ.
#pragma once

#include <patchwright/geom/types.h>

#include <filesystem>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::mesh {

struct Polyline {
    geom::Points points;  ///< n x 3, n >= 2; of closed ones each once
    bool closed = false;
    int line = 0;  ///< of the file, where it was read from one
};

/// The `l` elements (v or v/vt, negative indices count back) of a file without faces. Those that
/// end where they began are closed. Elements of one edge each, as Blender writes them, are one
/// polyline where two of them meet and nothing else does; longer ones stay as they are.
/// @return empty where the file has faces
/// @throw InputError when it cannot be opened or holds neither, or naming the line of a malformed
///        statement
std::vector<Polyline> read_polylines(const std::filesystem::path& path);

/// The text of an OBJ file from which read_polylines gives the same, points to the last bit.
std::string polylines_text(const std::vector<Polyline>& polylines);

struct PolylineSummary {
    int count = 0, closed = 0, points = 0;
};
PolylineSummary summarise(const std::vector<Polyline>& polylines);

}  // namespace patchwright::mesh
#pragma GCC visibility pop
