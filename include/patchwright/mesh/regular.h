// Regular faces and steps between them, as on a grid.
#pragma once

#include <patchwright/mesh/topology.h>

#pragma GCC visibility push(default)
namespace patchwright::mesh {

/// Whether the limit surface over the face is one bicubic polynomial: a quad among quads, with four
/// faces around its vertices, two at creases, one at corners; sharp is infinitely sharp.
bool is_regular(const Topology& t, FaceId f);

/// Whether the limit surface may have a kink at the edge.
inline bool is_sharp(const Topology& t, EdgeId e) { return std::isinf(t.sharpness(e)); }

// A quad as the corner at its lowest u and v. Its neighbours likewise, in the same directions.
// @pre the edge between is no boundary edge, and the neighbour is a quad

inline CornerId right_of(const Topology& t, CornerId c) { return t.next(t.twin(t.next(c))); }
inline CornerId left_of(const Topology& t, CornerId c) { return t.previous(t.twin(t.previous(c))); }
inline CornerId above(const Topology& t, CornerId c) { return t.twin(t.next(t.next(c))); }
inline CornerId below(const Topology& t, CornerId c) { return t.next(t.next(t.twin(c))); }

}  // namespace patchwright::mesh
#pragma GCC visibility pop
