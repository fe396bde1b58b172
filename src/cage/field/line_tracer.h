// Lines that follow a cross field over triangles.
#pragma once

#include "cage/field/lined_mesh.h"
#include "cage/poll.h"

#include <vector>

namespace patchwright::cage {

struct LineStart {
    int vertex = -1;
    geom::Vec3 direction = geom::Vec3::Zero();  ///< in the plane of one of its triangles
};

enum class LineEnd {
    Wall,    ///< at the last of its points
    Vertex,  ///< at the vertex that it was to meet
    Own,     ///< before it enters a triangle again
    Lost     ///< it cannot go on
};

struct TracedLine {
    std::vector<SidePoint> points;  ///< where it crosses sides
    LineEnd end = LineEnd::Lost;
    int end_vertex = -1;  ///< for LineEnd::Vertex
    /// Where it ends, as it goes on: for LineEnd::Own and Vertex in the triangle that it is in.
    geom::Vec3 direction = geom::Vec3::Zero();
    double length = 0.0;  ///< without what is left to end_vertex
};

struct TraceOptions {
    double deviation = 0.0;      ///< from the field, radians, to the left
    bool crosses_lines = false;  ///< goes on across lines that it meets at a good angle
    bool straight = false;       ///< goes straight on, whatever the field
    int passes = 1;              ///< times that it may enter a triangle; to be drawn, once
    /// One a vertex: ends where it comes to a triangle of one that is marked; may be shorter.
    const std::vector<char>* meets = nullptr;
};

/// What is told of each step: in a triangle, from a point to the next.
using StepSeen = std::function<void(int triangle, const geom::Vec3& from, const geom::Vec3& to,
                                    double length_before)>;

TracedLine trace_line(const LinedMesh& lined, const LineStart& start, const TraceOptions& options,
                      Poll& poll, const StepSeen& seen = {});

}  // namespace patchwright::cage
