// A control mesh: connectivity that many may share, and the points that belong to one.
#pragma once

#include <patchwright/geom/types.h>
#include <patchwright/mesh/topology.h>

#include <memory>
#include <string_view>

#pragma GCC visibility push(default)
namespace patchwright::mesh {

struct Cage {
    std::shared_ptr<const Topology> topology;
    geom::Points points;  ///< one row a vertex
};

/// A checked cage and what had to be done to it.
struct BuildResult {
    Cage cage;
    int flipped_faces =
        0;  ///< faces whose vertex order was reversed; their first vertex stays first
    int removed_vertices = 0;  ///< inner ones with two faces only; later ones moved up
};

/// Which way closed parts face in the end.
enum class Facing {
    Outward,  ///< positive volume
    AsGiven   ///< as most of their faces: inward ones bound hollows
};

/// Checks and connects. Neighbouring faces that disagree in orientation are turned to the
/// majority's side; closed parts then face outward unless asked otherwise. An inner vertex with two
/// faces goes where it has no tag, both faces keep three vertices and its two edges are equally
/// sharp and become one that is new.
/// @param source  put before every message, usually the file name
/// @throw InputError naming the first offending element (vertices and faces count from 1, as in an
///        OBJ file, but for those of tags, which count from 0) and its line: a face with fewer than
///        three or with repeated vertices, a duplicate face, an index out of range, a coordinate
///        beyond geom::largest_coordinate, an edge with more than two faces, a vertex whose faces
///        form more than one fan, an inner vertex with two faces that cannot go, an unused vertex,
///        a one-sided (Moebius) part, a tag on an edge or vertex that does not exist, a negative or
///        non-finite-but-not-infinite sharpness, a sector not bounded by two sharp edges
BuildResult build_cage(TopologyInput input, geom::Points points, std::string_view source = "cage",
                       Facing facing = Facing::Outward);

/// Whether the limit surface around the vertex is not that of a regular grid: smooth inside with
/// other than four faces, or with other than two faces (one at corners) between neighbouring
/// infinitely sharp edges, or the end of a single one.
bool is_extraordinary(const Topology& topology, VertexId v);

/// What a person wants to know about a cage before using it.
struct CageSummary {
    int vertices = 0;
    int faces = 0;
    int non_quads = 0;
    int extraordinary = 0;  ///< see is_extraordinary()
    int creases = 0;        ///< edges with a sharpness tag, boundary not counted
    int corners = 0;        ///< vertices with a sharpness tag
    int boundary_edges = 0;
    int pins = 0;
};

CageSummary summarise(const Topology& topology);

}  // namespace patchwright::mesh
#pragma GCC visibility pop
