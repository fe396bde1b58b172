// What is in a CAD model, and whether it is a sound solid.
#pragma once

#include <patchwright/geom/types.h>
#include <patchwright/occ/cad_model.h>
#include <patchwright/patch/continuity.h>

#include <map>
#include <string>

#pragma GCC visibility push(default)
namespace patchwright::occ {

/// Counts and measures of a model; lengths in millimetres.
struct Inspection {
    int solids = 0;
    int shells_closed = 0;
    int shells_open = 0;
    int faces = 0;
    int edges = 0;              ///< distinct, without degenerate ones
    int vertices = 0;           ///< distinct
    int free_edges = 0;         ///< used by one face
    int nonmanifold_edges = 0;  ///< used by more than two
    std::map<std::string, int>
        faces_by_kind;  ///< "plane", "bspline 3x3", "bspline 3x3 rational", ...
    geom::Box3 bounds;
    double volume_mm3 = 0.0;  ///< sum over the solids
    double area_mm2 = 0.0;
    double max_tolerance_mm = 0.0;
    bool valid = false;   ///< BRepCheck_Analyzer
    bool closed = false;  ///< at least one face, and every edge is used exactly twice
    bool all_bicubic =
        false;  ///< every surface a non-rational bicubic B-spline covered to its bounds
};

Inspection inspect(const CadModel& model);

struct ContinuityOptions {
    int samples_per_edge = 9;  ///< >= 2, both ends included
    /// Vertices without a tangent plane: kinks within the distance of one are told apart. Where an
    /// edge comes out of that neighbourhood there are more samples.
    geom::Points singular_points = geom::Points(0, 3);
    double singular_distance_mm = 0.0;
};

/// How neighbouring faces meet along their shared edges, measured on both surfaces.
/// @param crease_points  one point on each edge that is a crease (any order), e.g. curve
/// mid-points; an
///                       edge is a crease when one lies within 1e-6 of the diagonal of its
///                       mid-point
patch::Continuity measure_continuity(const CadModel& model, const geom::Points& crease_points,
                                     const ContinuityOptions& options = {});

}  // namespace patchwright::occ
#pragma GCC visibility pop
