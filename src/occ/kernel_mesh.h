// Triangles by the kernel, whose refinement ends where it would no longer pay.
#pragma once

#include <IMeshTools_Parameters.hxx>
#include <Message_ProgressRange.hxx>
#include <TopoDS_Shape.hxx>

namespace patchwright::occ {

/// Of one face. The kernel keeps nodes in 14 by 14 cells, so its work grows with their square:
/// 18,000 nodes along a fold take 2 s, 68,000 take 15 s. Faces of usual models have up to 22,000.
inline constexpr int most_face_nodes = 30000;

/// Of one edge, whose nodes may all be in one cell where it winds: 20,000 take 20 s.
/// Edges of usual models have up to 60, those of a thread up to 20 in each turn.
inline constexpr int most_edge_nodes = 5000;

/// Triangulates the faces in place, as the kernel does: each B-spline face in up to 11 passes that
/// add nodes where triangles are too far from the face or turn too much. Ends a face's passes
/// * before it would have more than `most_face_nodes`: a sheet thinner than its deflection turns at
///   its fold in triangles of any size;
/// * where a piece of the face's border has no triangle, as borders that cross themselves have:
///   from then on each pass walks through all triangles in search of a polygon beside the piece.
/// Such a face keeps the triangles that it has, which may be coarser than asked for. A face that
/// has an edge of more than `most_edge_nodes` gets no triangles.
void mesh_faces(const TopoDS_Shape& shape, const IMeshTools_Parameters& parameters,
                const Message_ProgressRange& range = {});

}  // namespace patchwright::occ
