#include "geom/disjoint_sets.h"

#include <patchwright/mesh/parts.h>

#include <map>

namespace patchwright::mesh {

namespace {

/// A topology in the making of faces of others.
class Collector {
  public:
    Collector() = default;
    /// @param like  whose rules are taken
    explicit Collector(const Topology& like) {
        input_.boundary_rule = like.boundary_rule();
        input_.crease_rule = like.crease_rule();
    }

    /// @param part  one a vertex; adds the faces and tags of those with this number
    void add(const Topology& t, const std::vector<int>& part, int number) {
        std::vector<int> vertex(std::size_t(t.vertex_count()), -1);
        for (const VertexId v : t.vertices())
            if (part[v.index()] == number) vertex[v.index()] = input_.vertex_count++;
        std::vector<int> face(std::size_t(t.face_count()), -1);
        for (const FaceId f : t.faces()) {
            const auto corners = t.corners(f);
            if (vertex[t.vertex(corners[0]).index()] < 0) continue;
            face[f.index()] = int(input_.face_sizes.size());
            input_.face_sizes.push_back(corners.size());
            for (const CornerId c : corners) {
                input_.face_vertices.push_back(vertex[t.vertex(c).index()]);
                if (!t.is_shifted(c)) continue;
                input_.edge_shifts.push_back({vertex[t.vertex(c).index()],
                                              vertex[t.vertex(t.next(c)).index()],
                                              t.edge_shift(c)});
            }
            if (t.group(f) < 0) continue;
            const std::string& name = t.group_names()[std::size_t(t.group(f))];
            const auto [group, added] = groups_.emplace(name, int(input_.group_names.size()));
            if (added) input_.group_names.push_back(name);
            input_.face_group.push_back(group->second);
        }
        for (const EdgeId e : t.edges()) {
            const int a = vertex[t.start(e).index()], b = vertex[t.end(e).index()];
            if (a >= 0 && t.tagged_sharpness(e) > 0.0)
                input_.creases.push_back({a, b, t.tagged_sharpness(e)});
        }
        for (const VertexId v : t.vertices()) {
            const int here = vertex[v.index()];
            if (here < 0) continue;
            if (t.tagged_sharpness(v) > 0.0)
                input_.corners.push_back({here, t.tagged_sharpness(v)});
            if (t.is_pinned(v)) input_.pins.push_back(here);
        }
        for (const SectorTagInput& tag : t.sectors()) {
            const int here = vertex[std::size_t(tag.vertex)];
            if (here >= 0)
                input_.sectors.push_back(
                    {here, face[std::size_t(tag.face)], tag.angle, tag.normal});
        }
    }

    [[nodiscard]] std::shared_ptr<const Topology> topology() {
        // Names are for all faces or for none.
        if (input_.face_group.size() != input_.face_sizes.size()) {
            input_.face_group.clear();
            input_.group_names.clear();
        }
        return std::make_shared<const Topology>(input_);
    }

  private:
    TopologyInput input_;
    std::map<std::string, int> groups_;
};

}  // namespace

std::vector<Cage> connected_parts(const Cage& cage) {
    const Topology& t = *cage.topology;
    geom::DisjointSets sets(std::size_t(t.vertex_count()));
    for (const FaceId f : t.faces())
        for (const CornerId c : t.corners(f))
            sets.join(t.vertex(c).value, t.vertex(t.next(c)).value);
    const std::vector<std::vector<int>> members = sets.sets();
    if (members.size() == 1) return {cage};
    std::vector<int> part(sets.size());
    for (std::size_t number = 0; number < members.size(); ++number)
        for (const int v : members[number]) part[std::size_t(v)] = int(number);
    std::vector<Cage> parts;
    for (std::size_t number = 0; number < members.size(); ++number) {
        Collector collector(t);
        collector.add(t, part, int(number));
        Cage one{collector.topology(), {}};
        one.points.resize(one.topology->vertex_count(), 3);
        Eigen::Index row = 0;
        for (const int v : members[number]) one.points.row(row++) = cage.points.row(v);
        parts.push_back(std::move(one));
    }
    return parts;
}

Cage joined(const std::vector<Cage>& parts) {
    if (parts.size() == 1) return parts.front();
    Collector collector = parts.empty() ? Collector() : Collector(*parts.front().topology);
    Eigen::Index rows = 0;
    for (const Cage& part : parts) {
        collector.add(*part.topology,
                      std::vector<int>(std::size_t(part.topology->vertex_count()), 0), 0);
        rows += part.points.rows();
    }
    Cage whole{collector.topology(), geom::Points(rows, 3)};
    rows = 0;
    for (const Cage& part : parts) {
        whole.points.middleRows(rows, part.points.rows()) = part.points;
        rows += part.points.rows();
    }
    return whole;
}

}  // namespace patchwright::mesh
