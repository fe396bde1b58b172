// What is in a CAD file: one that went in, came out or was inspected.
#pragma once

#include <patchwright/base/units.h>
#include <patchwright/geom/types.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::report {

/// The CAD file that went in. Lengths here and below are millimetres; the writers convert.
struct InputFigures {
    std::string file, format, schema, originating_system;
    base::LengthUnit unit = base::LengthUnit::Millimetre;
    int solids = 0;
    int faces = 0;
    int free_edges = 0;  ///< after reading and sewing
    double diagonal = 0.0;
    std::optional<double> largest_gap_closed, sewing_tolerance;
    int holes_left_out = 0;  ///< narrower than the tolerance
};

/// The CAD file that came out, or one that was inspected, as read back from disk.
struct SolidFigures {
    std::string file;
    int solids = 0, shells_closed = 0, shells_open = 0;
    int faces = 0, edges = 0, vertices = 0, free_edges = 0, nonmanifold_edges = 0;
    std::map<std::string, int> faces_by_kind;
    bool closed = false;
    bool valid = false;
    bool all_bicubic = false;
    double volume = 0.0;
    double area = 0.0;
    double max_tolerance = 0.0;
    geom::Box3 bounds;
};

/// What a closer look at an inspected file found; see occ::CloseInspection. Faces count from 0.
struct DetailFigures {
    int smallest_face = 0;
    double smallest_area = 0.0;
    std::optional<int> narrowest_face;
    double narrowest_width = 0.0;
    std::optional<double> shortest_edge;
    geom::Vec3 shortest_edge_at = geom::Vec3::Zero();
    double vertex_tolerance = 0.0, edge_tolerance = 0.0, face_tolerance = 0.0;
    std::optional<double> smallest_open_gap, largest_open_gap;
    int sharp_edges = 0, smooth_edges = 0, sharp_curves = 0, free_curves = 0, corners = 0;
    int kinked_faces = 0;
    double largest_kink_rad = 0.0;
    geom::Vec3 largest_kink_at = geom::Vec3::Zero();
    geom::Vec3 centre_of_mass = geom::Vec3::Zero();
    std::array<double, 3> principal_moments{0.0, 0.0, 0.0};
    bool moments_of_volume = false;  ///< else of the surface
    int named_faces = 0, coloured_faces = 0;
    std::vector<std::array<int, 2>> overlapping_solids;
    int duplicates_dropped = 0, slivers_dropped = 0, faces_turned = 0;
};

}  // namespace patchwright::report
#pragma GCC visibility pop
