#include "patch/cap.h"
#include "patch/chart_surface.h"
#include "patch/connect.h"
#include "patch/layout.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/patch/extract.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace patchwright::patch {

namespace {

using mesh::CornerId;
using mesh::FaceId;
using mesh::Topology;

/// Of the cage's diagonal: a tenth of 1e-4, the tolerance of a close conversion.
constexpr double default_tolerance_rel = 1e-5;

void check(const ExtractOptions& options) {
    if (options.cap_depth && (*options.cap_depth < 1 || *options.cap_depth > max_cap_depth)) {
        throw base::InvalidArgument(fmt::format("cap depth {} is out of range; use 1 to {}",
                                                *options.cap_depth, max_cap_depth));
    }
    if (options.tolerance_mm && !(*options.tolerance_mm > 0.0)) {
        throw base::InvalidArgument(
            fmt::format("tolerance {} mm is not positive", *options.tolerance_mm));
    }
}

/// The groups that the chart's faces belong to, in order, then its number.
std::string chart_name(const Topology& t, const Chart& chart, std::size_t number,
                       Covering covering) {
    std::set<int> groups;
    for (const CornerId c : chart.cells) groups.insert(t.group(t.face(c)));
    std::string name;
    for (const int group : groups) {
        if (group < 0) continue;
        if (!name.empty()) name += '+';
        name += t.group_names()[std::size_t(group)];
    }
    if (!name.empty()) name += '/';
    return name + fmt::format("{} {}", covering == Covering::Faces ? "face" : "chart", number);
}

void find_kinds(SurfaceSource& source) {
    const Topology& t = *source.cage.topology;
    source.kinds.resize(std::size_t(t.face_count()));
    base::parallel_for(source.kinds.size(), 1024, [&](std::size_t first, std::size_t last) {
        for (std::size_t f = first; f < last; ++f) {
            source.kinds[f] = source.table.ring(t, FaceId{static_cast<std::int32_t>(f)}).kind;
        }
    });
}

void build_caps(SurfaceSource& source, const ExtractOptions& options) {
    const Topology& t = *source.cage.topology;
    std::vector<Fan> irregular;
    for (const mesh::VertexId v : t.vertices()) {
        for (Fan& fan : fans_around(t, v)) {
            if (fan.is_controlled) {
                throw base::InputError(fmt::format(
                    "sector at vertex {} (counted from 0): no finite number of bicubic pieces "
                    "has the shape that its angle makes; take the angle away (0), or use a grid",
                    v.value));
            }
            if (!fan.is_regular()) irregular.push_back(std::move(fan));
        }
    }
    const double tolerance = options.tolerance_mm.value_or(
        default_tolerance_rel * geom::bounding_box(source.cage.points).diagonal());
    CapBuilder builder(source.cage, options, tolerance, source.table);
    source.caps.resize(irregular.size());
    base::parallel_for(irregular.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) source.caps[k] = builder.build(irregular[k]);
    });
    for (std::size_t k = 0; k < irregular.size(); ++k) {
        for (std::size_t place = 0; place < irregular[k].corners.size(); ++place) {
            source.cap_at[irregular[k].corners[place].value] = {std::int32_t(k),
                                                                std::int32_t(place)};
        }
    }
}

std::vector<EdgeContinuity> continuity_at_vertices(const SurfaceSource& source) {
    std::vector<EdgeContinuity> at_vertex(std::size_t(source.cage.topology->vertex_count()),
                                          EdgeContinuity::Curvature);
    for (const Cap& cap : source.caps) {
        EdgeContinuity& known = at_vertex[cap.fan.vertex.index()];
        known = std::min(
            known, cap.report.smooth ? EdgeContinuity::TangentPlane : EdgeContinuity::Position);
    }
    return at_vertex;
}

/// Irregular corners of faces are corners of charts.
bool has_cap(const Chart& chart, const SurfaceSource& source) {
    for (const int i : {0, chart.columns - 1}) {
        for (const int j : {0, chart.rows - 1}) {
            for (const CornerId c :
                 source.cage.topology->corners(source.cage.topology->face(chart.cell(i, j)))) {
                if (source.cap_at.contains(c.value)) return true;
            }
        }
    }
    return false;
}

geom::Points rows_of(const std::vector<geom::Vec3>& points) {
    geom::Points rows(Eigen::Index(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i) rows.row(Eigen::Index(i)) = points[i];
    return rows;
}

}  // namespace

Extraction extract(const mesh::Cage& cage, const ExtractOptions& options) {
    check(options);
    Extraction extraction;
    extraction.cage = cage;
    if (!cage.topology->all_quads()) {
        extraction.cage = subd::refine(cage, 1);
        extraction.refinements = 1;
    }
    const Topology& t = *extraction.cage.topology;
    subd::RingTable table;
    SurfaceSource source{extraction.cage, table, {}, {}, {}};
    find_kinds(source);
    build_caps(source, options);

    const std::vector<Chart> charts = cover(t, options.covering);
    std::vector<Patch>& patches = extraction.patches.patches;
    patches.resize(charts.size());
    base::parallel_for(charts.size(), 16, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            patches[k].surface = chart_surface(charts[k], source);
            patches[k].has_cap = has_cap(charts[k], source);
            patches[k].name = chart_name(t, charts[k], k, options.covering);
        }
    });
    connect(t, charts, continuity_at_vertices(source), extraction.patches);
    for (const Cap& cap : source.caps) extraction.caps.push_back(cap.report);
    return extraction;
}

geom::Points crease_midpoints(const PatchSet& patches) {
    std::vector<geom::Vec3> middles;
    for (const PatchEdge& edge : patches.edges) {
        if (edge.crease)
            middles.push_back(edge.curve.at(0.5 * (edge.curve.begin() + edge.curve.end())));
    }
    return rows_of(middles);
}

geom::Points singular_points(const Extraction& extraction) {
    std::set<mesh::VertexId> vertices;  // a vertex has one cap a side of its sharp edges
    for (const CapReport& cap : extraction.caps)
        if (!cap.limit_has_plane || !cap.smooth) vertices.insert(cap.vertex);
    std::vector<geom::Vec3> points;
    const subd::LimitEvaluator limit(extraction.cage.topology);
    for (const mesh::VertexId v : vertices)
        points.push_back(limit.position(extraction.cage.points, v));
    return rows_of(points);
}

}  // namespace patchwright::patch
