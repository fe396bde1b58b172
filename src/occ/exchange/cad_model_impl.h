// The kernel side of CadModel; for sources of this room only.
#pragma once

#include <patchwright/occ/cad_model.h>
#include <patchwright/patch/patch_set.h>

#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <optional>
#include <string>
#include <vector>

namespace patchwright::occ {

struct CadModel::Impl {
    TopoDS_Shape shape;  ///< millimetres; a compound, solid or shell
    /// One a face in faces_of() order, empty strings where unnamed; or an empty list.
    std::vector<std::string> face_names;
    std::vector<std::optional<Colour>> face_colours;  ///< likewise
};

/// The faces in the order that every face number of this room refers to (TopExp::MapShapes order).
std::vector<TopoDS_Face> faces_of(const CadModel& model);

/// How often faces use each distinct edge (a seam twice by its one face), without degenerate edges.
std::vector<int> edge_uses(const TopoDS_Shape& shape);

/// The same, with the edges in that order.
std::vector<int> edge_uses(const TopoDS_Shape& shape, TopTools_IndexedMapOfShape& edges);

/// Edges used once.
int count_free_edges(const TopoDS_Shape& shape);

}  // namespace patchwright::occ
