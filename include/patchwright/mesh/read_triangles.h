// Triangles from STL and OBJ files.
#pragma once

#include <patchwright/geom/triangle_mesh.h>

#include <filesystem>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::mesh {

/// By extension: .stl, .obj (any case).
bool is_triangle_file(const std::filesystem::path& path);

struct TriangleFile {
    geom::TriangleMesh mesh;  ///< sound; millimetres
    geom::MeshRepair repair;
    std::string format;                ///< "STL binary", "STL ASCII" or "OBJ"
    bool is_control_mesh = false;      ///< an OBJ file with tags of subdivision
    std::vector<std::string> notices;  ///< one line each, for the user
};

/// Reads STL, binary or ASCII whatever the first word says, or the polygons of an OBJ file cut into
/// triangles; names of solids, groups and objects become parts. These files hold no unit.
/// @param scale  millimetres in one unit of the file's numbers
/// @throw InputError as geom::make_sound, or when the file is missing, truncated or malformed
TriangleFile read_triangles(const std::filesystem::path& path, double scale = 1.0);

}  // namespace patchwright::mesh
#pragma GCC visibility pop
