#include "mesh/two_face_vertices.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

namespace patchwright::mesh {

namespace {

using Edge = std::pair<int, int>;

Edge edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

class Remover {
  public:
    Remover(TopologyInput& input, geom::Points& points) : input_(input), points_(points) {}

    std::vector<int> run() {
        find_candidates();
        if (candidates_.empty()) return {};
        find_edges();
        gone_.assign(std::size_t(input_.vertex_count), 0);
        bool any = false;
        for (const auto& [v, faces] : candidates_) any = remove(v, faces) || any;
        return any ? renumber() : std::vector<int>{};
    }

  private:
    using Faces = std::array<std::size_t, 2>;

    void find_candidates() {
        std::vector<int> count(std::size_t(input_.vertex_count), 0);
        for (const int v : input_.face_vertices) ++count[std::size_t(v)];
        if (std::find(count.begin(), count.end(), 2) == count.end()) return;
        auto next = input_.face_vertices.begin();
        std::map<int, std::vector<std::size_t>> faces_of;
        for (std::size_t f = 0; f < input_.face_sizes.size(); ++f) {
            faces_.emplace_back(next, next + input_.face_sizes[f]);
            next += input_.face_sizes[f];
            for (const int v : faces_.back())
                if (count[std::size_t(v)] == 2) faces_of[v].push_back(f);
        }
        for (const auto& [v, faces] : faces_of) {
            if (edge_across(v, faces[0]) == edge_across(v, faces[1]))
                candidates_.push_back({v, {faces[0], faces[1]}});
        }
    }

    void find_edges() {
        for (const auto& face : faces_)
            for (std::size_t i = 0; i < face.size(); ++i)
                edges_.insert(edge_of(face[i], face[(i + 1) % face.size()]));
        for (const EdgeTagInput& tag : input_.creases) {
            sharpness_[edge_of(tag.v0, tag.v1)] = tag.sharpness;
            if (!edges_.contains(edge_of(tag.v0, tag.v1))) tagged_.insert({tag.v0, tag.v1});
        }
        for (const EdgeShiftInput& tag : input_.edge_shifts) tagged_.insert({tag.v0, tag.v1});
        for (const VertexTagInput& tag : input_.corners) tagged_.insert(tag.vertex);
        for (const SectorTagInput& tag : input_.sectors) tagged_.insert(tag.vertex);
        tagged_.insert(input_.pins.begin(), input_.pins.end());
    }

    /// The neighbours of a vertex within a face.
    [[nodiscard]] Edge edge_across(int v, std::size_t f) const {
        const auto& face = faces_[f];
        const auto i = std::size_t(std::find(face.begin(), face.end(), v) - face.begin());
        return edge_of(face[(i + face.size() - 1) % face.size()], face[(i + 1) % face.size()]);
    }

    [[nodiscard]] double sharpness(int a, int b) const {
        const auto found = sharpness_.find(edge_of(a, b));
        return found == sharpness_.end() ? 0.0 : found->second;
    }

    bool remove(int v, const Faces& faces) {
        const Edge across = edge_across(v, faces[0]);
        const bool harmless = faces_[faces[0]].size() > 3 && faces_[faces[1]].size() > 3 &&
                              !tagged_.contains(v) && !edges_.contains(across) &&
                              sharpness(v, across.first) == sharpness(v, across.second);
        if (!harmless) return false;
        sharpness_[across] = sharpness(v, across.first);
        edges_.insert(across);
        for (const std::size_t f : faces) std::erase(faces_[f], v);
        for (const int end : {across.first, across.second}) {
            edges_.erase(edge_of(v, end));
            replaced_by_[edge_of(v, end)] = across;
        }
        gone_[std::size_t(v)] = 1;
        return true;
    }

    std::vector<int> renumber() {
        std::vector<int> old_number, number(gone_.size(), -1);
        for (std::size_t v = 0; v < gone_.size(); ++v) {
            if (gone_[v] != 0) continue;
            number[v] = int(old_number.size());
            points_.row(number[v]) = points_.row(Eigen::Index(v)).eval();
            auto& lines = input_.lines.vertices;
            if (!lines.empty()) lines[old_number.size()] = lines[v];
            old_number.push_back(int(v));
        }
        points_.conservativeResize(Eigen::Index(old_number.size()), 3);
        input_.vertex_count = int(old_number.size());
        input_.face_vertices.clear();
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            input_.face_sizes[f] = int(faces_[f].size());
            for (const int v : faces_[f]) input_.face_vertices.push_back(number[std::size_t(v)]);
        }
        renumber_tags(number);
        return old_number;
    }

    void renumber_tags(const std::vector<int>& number) {
        // Tags of vertices that do not exist are refused later.
        const auto renumbered = [&](int v) {
            return v >= 0 && std::size_t(v) < number.size() ? number[std::size_t(v)] : v;
        };
        for (EdgeTagInput& tag : input_.creases) {
            Edge edge = edge_of(tag.v0, tag.v1);
            for (auto by = replaced_by_.find(edge); by != replaced_by_.end();
                 by = replaced_by_.find(edge))
                edge = by->second;
            tag.v0 = renumbered(edge.first);
            tag.v1 = renumbered(edge.second);
        }
        for (VertexTagInput& tag : input_.corners) tag.vertex = renumbered(tag.vertex);
        for (SectorTagInput& tag : input_.sectors) tag.vertex = renumbered(tag.vertex);
        for (int& v : input_.pins) v = renumbered(v);
        for (EdgeShiftInput& tag : input_.edge_shifts) {
            tag.v0 = renumbered(tag.v0);
            tag.v1 = renumbered(tag.v1);
        }
    }

    TopologyInput& input_;
    geom::Points& points_;
    std::vector<std::vector<int>> faces_;
    std::vector<std::pair<int, Faces>> candidates_;
    std::set<Edge> edges_;
    std::map<Edge, double> sharpness_;
    std::map<Edge, Edge> replaced_by_;
    std::set<int> tagged_;
    std::vector<char> gone_;
};

}  // namespace

std::vector<int> remove_two_face_vertices(TopologyInput& input, geom::Points& points) {
    return Remover(input, points).run();
}

}  // namespace patchwright::mesh
