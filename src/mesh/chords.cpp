#include "geom/disjoint_sets.h"

#include <patchwright/mesh/chords.h>

#include <array>

namespace patchwright::mesh {

namespace {

class Splitter {
  public:
    Splitter(const Topology& topology, const Chords& chords, const std::vector<char>& chosen)
        : topology_(topology), middle_(std::size_t(topology.edge_count()), -1) {
        fine_.vertex_count = topology.vertex_count();
        result_.vertices.resize(std::size_t(topology.vertex_count()));
        for (const EdgeId e : topology.edges()) {
            if (chosen[std::size_t(chords.of_edge[e.index()])] == 0) continue;
            middle_[e.index()] = fine_.vertex_count++;
        }
        result_.vertices.resize(std::size_t(fine_.vertex_count));
    }

    ChordSplit split() && {
        fine_.group_names = topology_.group_names();
        fine_.boundary_rule = topology_.boundary_rule();
        fine_.crease_rule = topology_.crease_rule();
        for (const FaceId f : topology_.faces()) split_face(f);
        carry_tags();
        result_.topology = std::make_shared<const Topology>(fine_);
        return std::move(result_);
    }

  private:
    void split_face(FaceId f) {
        const auto corners = topology_.corners(f);
        std::array<int, 4> p{}, m{};
        constexpr std::array<std::array<double, 2>, 4> at{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
        for (int i = 0; i < 4; ++i) {
            const auto k = std::size_t(i);
            p[k] = topology_.vertex(corners[i]).value;
            m[k] = middle_[topology_.edge(corners[i]).index()];
            const auto& a = at[k];
            const auto& b = at[(k + 1) % 4];
            result_.vertices[std::size_t(p[k])] = {f, a[0], a[1]};
            if (m[k] >= 0)
                result_.vertices[std::size_t(m[k])] = {f, 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])};
        }
        const bool u = m[0] >= 0, v = m[1] >= 0;
        result_.cuts.push_back((u ? 1 : 0) + (v ? 2 : 0));
        if (u && v) {
            const int c = fine_.vertex_count++;
            result_.vertices.push_back({f, 0.5, 0.5});
            add(f, {p[0], m[0], c, m[3]});
            add(f, {m[0], p[1], m[1], c});
            add(f, {c, m[1], p[2], m[2]});
            add(f, {m[3], c, m[2], p[3]});
        } else if (u) {
            add(f, {p[0], m[0], m[2], p[3]});
            add(f, {m[0], p[1], p[2], m[2]});
        } else if (v) {
            add(f, {p[0], p[1], m[1], m[3]});
            add(f, {m[3], m[1], p[2], p[3]});
        } else {
            add(f, p);
        }
    }

    void add(FaceId parent, const std::array<int, 4>& vertices) {
        fine_.face_sizes.push_back(4);
        fine_.face_vertices.insert(fine_.face_vertices.end(), vertices.begin(), vertices.end());
        if (!topology_.group_names().empty()) fine_.face_group.push_back(topology_.group(parent));
        result_.parents.push_back(parent);
    }

    void carry_tags() {
        for (const EdgeId e : topology_.edges()) {
            const double sharpness = topology_.tagged_sharpness(e);
            if (!(sharpness > 0.0)) continue;
            const int a = topology_.start(e).value, b = topology_.end(e).value;
            const int m = middle_[e.index()];
            fine_.creases.push_back({a, m >= 0 ? m : b, sharpness});
            if (m >= 0) fine_.creases.push_back({m, b, sharpness});
        }
        for (const VertexId v : topology_.vertices()) {
            const double sharpness = topology_.tagged_sharpness(v);
            if (sharpness > 0.0) fine_.corners.push_back({v.value, sharpness});
            if (topology_.is_pinned(v)) fine_.pins.push_back(v.value);
        }
        for (const SectorTagInput& tag : topology_.sectors()) {
            fine_.sectors.push_back(
                {tag.vertex, child_at(FaceId{tag.face}, tag.vertex), tag.angle, tag.normal});
        }
        for (const FaceId f : topology_.faces()) {
            for (const CornerId c : topology_.corners(f)) {
                if (!topology_.is_shifted(c)) continue;
                const int m = middle_[topology_.edge(c).index()];
                const int end = m >= 0 ? m : topology_.vertex(topology_.next(c)).value;
                fine_.edge_shifts.push_back(
                    {topology_.vertex(c).value, end, topology_.edge_shift(c)});
            }
        }
    }

    /// The child of a face that has this vertex.
    [[nodiscard]] int child_at(FaceId parent, int vertex) const {
        for (std::size_t i = 0; i < result_.parents.size(); ++i) {
            if (result_.parents[i] != parent) continue;
            for (std::size_t k = 0; k < 4; ++k) {
                if (fine_.face_vertices[4 * i + k] == vertex) return static_cast<int>(i);
            }
        }
        return -1;
    }

    const Topology& topology_;
    std::vector<int> middle_;  // by edge; -1: not split
    TopologyInput fine_;
    ChordSplit result_;
};

}  // namespace

Chords find_chords(const Topology& topology) {
    geom::DisjointSets sets(std::size_t(topology.edge_count()));
    for (const FaceId f : topology.faces()) {
        const auto corners = topology.corners(f);
        for (int i = 0; i < 2; ++i)
            sets.join(topology.edge(corners[i]).value, topology.edge(corners[i + 2]).value);
    }
    Chords chords;
    chords.of_edge.assign(sets.size(), -1);
    for (const EdgeId e : topology.edges()) {
        const int first = sets.find(e.value);
        chords.of_edge[e.index()] =
            first == e.value ? chords.count++ : chords.of_edge[std::size_t(first)];
    }
    return chords;
}

ChordSplit split_chords(const Topology& topology, const Chords& chords,
                        const std::vector<char>& chosen) {
    return Splitter(topology, chords, chosen).split();
}

}  // namespace patchwright::mesh
