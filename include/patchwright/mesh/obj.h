// Wavefront OBJ with OpenSubdiv's `t` tags and patchwright's pins and sectors.
#pragma once

#include <patchwright/mesh/cage.h>

#include <filesystem>
#include <istream>
#include <string>

#pragma GCC visibility push(default)
namespace patchwright::mesh {

/// Reads `v`, `f` (v, v/vt, v//vn, v/vt/vn; negative indices count back), `g` and `o` (names of the
/// faces that follow), `t crease 2/1/0 v0 v1 s`, `t corner 1/1/0 v s`, `t interpolateboundary 1/0/0
/// {1|2}` (tag indices count from 0) and `#patchwright pin v` and
/// `#patchwright sector v f degrees [nx ny nz]` (see SectorTagInput). Other statements are skipped.
/// @param source  put before every message together with the line number
/// @throw InputError as build_cage, or naming file and line of a malformed statement
BuildResult read_obj(std::istream& stream, const std::string& source);

/// @throw InputError also when the file cannot be opened
BuildResult read_obj(const std::filesystem::path& path);

/// The text of an OBJ file from which read_obj gives the same cage, points to the last bit.
std::string obj_text(const Cage& cage);

}  // namespace patchwright::mesh
#pragma GCC visibility pop
