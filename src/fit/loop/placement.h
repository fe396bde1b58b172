// How vertices move along with those of chains.
#pragma once

#include <patchwright/fit/fit.h>

#include <map>
#include <optional>

namespace patchwright::fit {

/// How vertices are to move, as far as that is known.
using Moves = std::map<mesh::VertexId, geom::Vec3>;

/// Displacements of all vertices, one a row, where some are known: each of the others is the mean
/// of its neighbours', weighted by the inverse lengths of edges and divided by 1 + fading, so that
/// vertices close to one that moves go along with it.
/// @param fading  at least 0; with 0.1, moves are 0.54 times those of the row before in an even
///                grid, and 0.64 times where edges along the rows are much longer
/// @return nothing where there is no such answer: for one, with a part that has no known ones and
///         does not fade
std::optional<geom::Points> carried_along(const mesh::Topology& topology,
                                          const geom::Points& points, const Moves& known,
                                          double fading);

/// A cage whose chains belong farther away than their own edges are long cannot be fitted step by
/// step: edges would pass each other. Its chains are moved to their targets and the other vertices
/// along with them, as a membrane would be; pinned ones stay. Any other cage is returned as it is.
mesh::Cage placed(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                  const FitOptions& options);

}  // namespace patchwright::fit
