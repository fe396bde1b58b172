// Cages that consist of several parts.
#pragma once

#include <patchwright/mesh/cage.h>

#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::mesh {

/// The connected components with their tags and groups, in the order of their first vertices;
/// vertices and faces keep their order.
std::vector<Cage> connected_parts(const Cage& cage);

/// One cage of all parts, which are not connected: vertices, faces and groups part after part;
/// groups of the same name become one.
/// @pre all parts have the same rules at boundaries and creases
Cage joined(const std::vector<Cage>& parts);

}  // namespace patchwright::mesh
#pragma GCC visibility pop
