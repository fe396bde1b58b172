// Layouts of triangulated shapes along the lines of a cross field.
#pragma once

#include "cage/blocks/brep_layout.h"
#include "cage/field/field_lines.h"
#include "cage/remesh/remesh.h"

#include <patchwright/geom/mesh_reference.h>

#include <utility>

namespace patchwright::test {

/// Its pieces may have several blocks.
struct FieldLayout {
    /// @param least_rel  of the diagonal: triangles' shortest sides, times two
    explicit FieldLayout(geom::TriangleMesh triangles, double least_rel = 8e-3)
        : reference(std::move(triangles)), mesh(reference.surface_mesh(0.0)) {
        cage::RemeshOptions options;
        options.size.largest_rel = 0.08;
        options.size.least_rel = least_rel;
        options.size.scale = 0.5;
        cage::Poll poll;  // never stops
        cage::remesh(mesh, reference, options, poll);
        cage::open_corners(mesh);
        cage::CrossField field =
            cage::cross_field(mesh, cage::curvature_hints(mesh, reference, poll), poll);
        const cage::FieldTopology topology = cage::field_topology(mesh, field);
        const cage::FieldLines lines = cage::field_lines(mesh, field, topology, poll);
        layout = cage::brep_layout(mesh, reference, poll, &lines);
    }

    geom::MeshReference reference;
    geom::EditableMesh mesh;
    cage::QuadLayout layout;
};

}  // namespace patchwright::test
