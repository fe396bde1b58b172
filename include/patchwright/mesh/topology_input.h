// Polygons and subdivision tags before they are connected.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::mesh {

inline constexpr double infinite_sharpness = std::numeric_limits<double>::infinity();
/// Sharpness of at least this counts as infinite, as in OpenSubdiv.
inline constexpr double sharpness_limit = 10.0;

/// What happens at the boundary; the values are those of OpenSubdiv's `interpolateboundary` tag.
enum class BoundaryRule {
    EdgeOnly = 1,      ///< boundary edges are creases
    EdgeAndCorner = 2  ///< and boundary vertices with one face are corners
};

/// How lines of control points, along edges, end at infinitely sharp edges; and these, where they
/// end at a corner. As end conditions of cubic splines.
enum class CreaseRule {
    CatmullClark,  ///< natural: the second derivative along the line is zero at its end
    /// The second derivative is constant along the line's last face: a crease costs half an order
    /// of approximation in the mean square, not one and a half. Where the line has three edges or
    /// more between creases and all faces are regular that the end acts on: two along the line and
    /// two on either side of it; in meshes of quads only. Elsewhere as CatmullClark.
    ParabolicRunout
};

struct EdgeTagInput {
    int v0, v1;
    double sharpness;
};

struct VertexTagInput {
    int vertex;
    double sharpness;
};

/// The faces between two infinitely sharp edges at a vertex whose shape is to be controlled.
struct SectorTagInput {
    int vertex;
    int face;  ///< any of the sector's
    /// What the sector spans, radians in (0, 2 pi): edge points near the vertex then follow the
    /// rule for that angle. 0: the ordinary rules.
    double angle = 0.0;
    std::array<double, 3> normal{};  ///< of the surface there; zero: free
};

/// The point of an edge is moved by shift * (v1 - v0) at every step; goes on with the half at v0.
struct EdgeShiftInput {
    int v0, v1;
    double shift;
};

/// Lines of a file, one an element, that messages name.
struct SourceLines {
    std::vector<int> vertices, faces, creases, corners, sectors, pins;
};

/// Polygons and tags as a file or a program gives them, unchecked.
struct TopologyInput {
    int vertex_count = 0;
    std::vector<int> face_sizes;     ///< one a face
    std::vector<int> face_vertices;  ///< face after face, counter-clockwise seen from outside
    std::vector<EdgeTagInput> creases;
    std::vector<VertexTagInput> corners;
    std::vector<SectorTagInput> sectors;
    std::vector<EdgeShiftInput> edge_shifts;  ///< besides those that sectors make
    std::vector<int> pins;                    ///< vertices whose control points a fit must not move
    std::vector<int> face_group;  ///< one a face, index into group_names; or empty: no names
    std::vector<std::string> group_names;
    BoundaryRule boundary_rule = BoundaryRule::EdgeOnly;
    CreaseRule crease_rule = CreaseRule::CatmullClark;
    SourceLines lines;  ///< empty: not from a file
};

}  // namespace patchwright::mesh
#pragma GCC visibility pop
