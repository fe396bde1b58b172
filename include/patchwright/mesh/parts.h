// Cages that consist of several parts.
#pragma once

#include <patchwright/mesh/cage.h>

#include <vector>

namespace patchwright::mesh {

/// The parts that do not hang together, with their tags, groups and the numbering of the whole, in
/// the order of their first vertices.
std::vector<Cage> connected_parts(const Cage& cage);

/// One cage of all parts, which stay apart: vertices, faces and groups part after part; groups of
/// the same name become one.
/// @pre all parts have the same boundary rule
Cage joined(const std::vector<Cage>& parts);

}  // namespace patchwright::mesh
