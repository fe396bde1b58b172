#include "mesh/runouts.h"

#include <patchwright/mesh/topology.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace patchwright::mesh {

namespace {

double clamp_sharpness(double sharpness) {
    return sharpness >= sharpness_limit ? infinite_sharpness : sharpness;
}

}  // namespace

Topology::Topology(const TopologyInput& input)
    : corner_vertex_(input.face_vertices.begin(), input.face_vertices.end()),
      vertex_corner_(static_cast<std::size_t>(input.vertex_count), -1),
      vertex_sharpness_(static_cast<std::size_t>(input.vertex_count), 0.0),
      sectors_(input.sectors),
      pinned_(static_cast<std::size_t>(input.vertex_count), 0),
      face_group_(input.face_group.begin(), input.face_group.end()),
      group_names_(input.group_names),
      boundary_rule_(input.boundary_rule) {
    face_begin_.reserve(input.face_sizes.size() + 1);
    face_begin_.push_back(0);
    for (const int size : input.face_sizes) {
        face_begin_.push_back(face_begin_.back() + size);
        all_quads_ = all_quads_ && size == 4;
    }
    corner_face_.resize(corner_vertex_.size());
    for (const FaceId f : faces()) {
        for (const CornerId c : corners(f)) corner_face_[c.index()] = f.value;
    }
    connect();

    edge_sharpness_.assign(edge_corner_.size(), 0.0);
    for (const EdgeTagInput& tag : input.creases) {
        const CornerId first = corner(VertexId{tag.v0});
        // Walk the half-edges around v0, both those that leave it and those that arrive.
        for (CornerId c = first; c.valid();) {
            if (vertex(next(c)).value == tag.v1) {
                edge_sharpness_[edge(c).index()] = clamp_sharpness(tag.sharpness);
            }
            if (vertex(previous(c)).value == tag.v1) {
                edge_sharpness_[edge(previous(c)).index()] = clamp_sharpness(tag.sharpness);
            }
            c = rotate(c);
            if (c == first) break;
        }
    }
    for (const VertexTagInput& tag : input.corners) {
        vertex_sharpness_[static_cast<std::size_t>(tag.vertex)] = clamp_sharpness(tag.sharpness);
    }
    for (const int v : input.pins) pinned_[static_cast<std::size_t>(v)] = 1;
    for (const SectorTagInput& tag : sectors_) {
        if (tag.angle == 0.0) continue;
        const auto fan =
            sector_corners(*this, find_corner(*this, FaceId{tag.face}, VertexId{tag.vertex}));
        // Biermann, Levin, Zorin (2000), 3.2: the edge point's weight 3/8 of the far end becomes
        // 3/8 - cos(angle / faces) / 4.
        const double shift = -0.25 * std::cos(tag.angle / double(fan.size()));
        // Two faces on a straight line follow the ordinary rule.
        if (fan.size() == 2 && std::abs(shift) < 1e-15) continue;
        for (std::size_t i = 1; i < fan.size(); ++i) shift_edge(fan[i], shift);
    }
    for (const EdgeShiftInput& tag : input.edge_shifts) {
        const CornerId first = corner(VertexId{tag.v0});
        for (CornerId c = first; c.valid();) {
            if (vertex(next(c)).value == tag.v1) shift_edge(c, tag.shift);
            c = rotate(c);
            if (c == first) break;
        }
    }
    set_crease_rule(input.crease_rule);
}

void Topology::set_crease_rule(CreaseRule rule) {
    crease_rule_ = rule;
    Runouts runouts;
    if (rule == CreaseRule::ParabolicRunout) runouts = find_runouts(*this);
    runouts_ = std::move(runouts.of_edge);
    near_runout_ = std::move(runouts.near_face);
}

Topology Topology::with(CreaseRule rule) const {
    Topology result = *this;
    result.set_crease_rule(rule);
    return result;
}

void Topology::shift_edge(CornerId c, double shift) {
    if (edge_shift_.empty()) edge_shift_.assign(corner_vertex_.size(), std::nan(""));
    edge_shift_[c.index()] = shift;
}

void Topology::connect() {
    // Half-edges in buckets by their lower vertex; the two halves of an edge meet in one bucket.
    const std::size_t corner_total = corner_vertex_.size();
    std::vector<std::int32_t> bucket(vertex_corner_.size() + 1, 0);
    const auto ends = [&](std::size_t c) {
        const auto a = corner_vertex_[c];
        const auto b = corner_vertex_[next(CornerId{static_cast<std::int32_t>(c)}).index()];
        return std::pair{std::min(a, b), std::max(a, b)};
    };
    for (std::size_t c = 0; c < corner_total; ++c) ++bucket[std::size_t(ends(c).first) + 1];
    std::partial_sum(bucket.begin(), bucket.end(), bucket.begin());
    std::vector<std::int32_t> sorted(corner_total);
    {
        auto fill = bucket;
        for (std::size_t c = 0; c < corner_total; ++c) {
            sorted[std::size_t(fill[std::size_t(ends(c).first)]++)] = static_cast<std::int32_t>(c);
        }
    }
    corner_twin_.assign(corner_total, -1);
    for (std::size_t v = 0; v + 1 < bucket.size(); ++v) {
        for (auto i = bucket[v]; i < bucket[v + 1]; ++i) {
            const auto a = sorted[std::size_t(i)];
            if (corner_twin_[std::size_t(a)] >= 0) continue;
            for (auto j = i + 1; j < bucket[v + 1]; ++j) {
                const auto b = sorted[std::size_t(j)];
                if (corner_twin_[std::size_t(b)] < 0 &&
                    ends(std::size_t(a)).second == ends(std::size_t(b)).second) {
                    corner_twin_[std::size_t(a)] = b;
                    corner_twin_[std::size_t(b)] = a;
                    break;
                }
            }
        }
    }
    // Edges in the order of their first corner; half-edges on the boundary take a vertex over.
    corner_edge_.resize(corner_total);
    for (std::size_t c = 0; c < corner_total; ++c) {
        const auto twin = corner_twin_[c];
        const bool first = twin < 0 || static_cast<std::size_t>(twin) > c;
        corner_edge_[c] = first ? static_cast<std::int32_t>(edge_corner_.size())
                                : corner_edge_[static_cast<std::size_t>(twin)];
        if (first) edge_corner_.push_back(static_cast<std::int32_t>(c));
        auto& leaving = vertex_corner_[static_cast<std::size_t>(corner_vertex_[c])];
        if (leaving < 0 || twin < 0) leaving = static_cast<std::int32_t>(c);
        closed_ = closed_ && twin >= 0;
    }
}

int Topology::face_valence(VertexId v) const {
    const CornerId first = corner(v);
    int count = 0;
    CornerId c = first;
    do {
        ++count;
        c = rotate(c);
    } while (c.valid() && c != first);
    return count;
}

double Topology::sharpness(VertexId v) const {
    if (boundary_rule_ == BoundaryRule::EdgeAndCorner && is_boundary(v) && face_valence(v) == 1) {
        return infinite_sharpness;
    }
    return vertex_sharpness_[v.index()];
}

std::vector<CornerId> sector_corners(const Topology& topology, CornerId c) {
    const auto sharp = [&](CornerId spoke) {
        return std::isinf(topology.sharpness(topology.edge(spoke)));
    };
    CornerId first = c;
    while (!sharp(first)) {
        first = topology.next(topology.twin(first));  // clockwise
        if (first == c) return {};
    }
    std::vector<CornerId> fan{first};
    while (!sharp(topology.previous(fan.back()))) fan.push_back(topology.rotate(fan.back()));
    return fan;
}

CornerId find_corner(const Topology& topology, FaceId f, VertexId v) {
    for (const CornerId c : topology.corners(f)) {
        if (topology.vertex(c) == v) return c;
    }
    return {};
}

}  // namespace patchwright::mesh
