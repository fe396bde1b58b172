#include "cage/field/merge_singularities.h"

#include "cage/field/vertex_fan.h"
#include "geom/shortest_paths.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Angles of quads at a corner between which the corner has room for them: half and one and a half
// times the angle of a square.
constexpr double least_angle = 0.25 * M_PI, most_angle = 0.75 * M_PI;

/// A singularity and a node that it may become one with.
struct NodePair {
    double length = 0.0;
    int singularity = -1;   ///< its vertex
    int node = -1;          ///< vertex of the other one, or of a corner
    std::vector<int> path;  ///< vertices from the first to the other one

    bool operator<(const NodePair& other) const {
        return std::tie(length, singularity, node) <
               std::tie(other.length, other.singularity, other.node);
    }
};

/// Harmonic angles on the triangles: zero where features hold the field, smooth but for jumps.
class HarmonicAngles {
  public:
    explicit HarmonicAngles(const geom::EditableMesh& mesh)
        : mesh_(mesh), number_(at(mesh.triangle_count()), -1) {
        for (int t = 0; t < mesh.triangle_count(); ++t)
            if (mesh.alive(t) && !is_held(t)) number_[at(t)] = unknowns_++;
        std::vector<Eigen::Triplet<double>> entries;
        for (int t = 0; t < mesh.triangle_count(); ++t) {
            if (number_[at(t)] < 0) continue;
            const int i = number_[at(t)];
            entries.emplace_back(i, i, anchor_weight);
            for (int k = 0; k < 3; ++k) {
                const int u = across(mesh, t, k);
                const double w = side_weight(mesh, t, k);
                entries.emplace_back(i, i, w);
                if (number_[at(u)] >= 0) entries.emplace_back(i, number_[at(u)], -w);
            }
        }
        Eigen::SparseMatrix<double> matrix(unknowns_, unknowns_);
        matrix.setFromTriplets(entries.begin(), entries.end());
        solver_.compute(matrix);
    }

    /// @param path  its jump is from the triangles on its right to those on its left
    /// @return one a triangle, radians
    [[nodiscard]] std::vector<double> solve(const std::vector<int>& path, double jump) const {
        Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns_);
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
            const geom::EdgeSides s = mesh_.sides(path[i], path[i + 1]);
            for (std::size_t j = 0; j < 2; ++j) {
                const int t = s.triangle[j];
                if (number_[at(t)] < 0) continue;
                const bool is_left = mesh_.triangle(t)[at(s.side[j])] == path[i];
                right[number_[at(t)]] +=
                    (is_left ? -jump : jump) * side_weight(mesh_, t, s.side[j]);
            }
        }
        const Eigen::VectorXd solution = solver_.solve(right);
        std::vector<double> result(number_.size(), 0.0);
        for (std::size_t t = 0; t < number_.size(); ++t)
            if (number_[t] >= 0) result[t] = solution[number_[t]];
        return result;
    }

  private:
    // Keeps surfaces without features determined.
    static constexpr double anchor_weight = 1e-9;

    [[nodiscard]] bool is_held(int t) const {
        for (int k = 0; k < 3; ++k)
            if (is_border(mesh_, t, k)) return true;
        return false;
    }

    const geom::EditableMesh& mesh_;
    int unknowns_ = 0;
    std::vector<int> number_;  ///< among the unknowns; -1: held or gone
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
};

class SingularityMerger {
  public:
    SingularityMerger(const geom::EditableMesh& mesh, CrossField& field, FieldTopology& topology,
                      double reach, Poll& poll)
        : mesh_(mesh),
          field_(field),
          topology_(topology),
          reach_(reach),
          poll_(poll),
          angles_(mesh) {}

    void run() {
        std::set<std::pair<int, int>> tried;
        while (true) {
            poll_();
            index_nodes();
            std::vector<NodePair> pairs;
            for (const auto& [vertex, quarters] : quarters_) add_pairs(vertex, pairs);
            std::sort(pairs.begin(), pairs.end());
            const auto next = std::find_if(pairs.begin(), pairs.end(), [&](const NodePair& pair) {
                return tried.insert({pair.singularity, pair.node}).second && merge(pair);
            });
            if (next == pairs.end()) return;
        }
    }

  private:
    void index_nodes() {
        quarters_.clear();
        sectors_.clear();
        for (const Singularity& s : topology_.singularities)
            if (mesh_.corner(s.vertex) < 0) quarters_[s.vertex] = 4 - s.valence;
        for (const FieldSector& s : topology_.sectors) sectors_[s.vertex].push_back(s);
    }

    /// The sector of a border vertex that a side to a vertex inside the surface is in.
    [[nodiscard]] std::optional<FieldSector> sector_towards(int v, int inside) const {
        const auto found = sectors_.find(v);
        if (found == sectors_.end()) return std::nullopt;
        const auto stops = [&](int a, int b) { return mesh_.is_feature(a, b); };
        for (const FieldSector& s : found->second)
            for (const Wedge& w : fan_from(mesh_, v, s.next, stops).wedges)
                if (w.next == inside) return s;
        return std::nullopt;
    }

    /// Whether a singularity may go into the node at the end of a path.
    [[nodiscard]] bool has_room(int quarters, int node, int before) const {
        const auto other = quarters_.find(node);
        if (other != quarters_.end()) return std::abs(other->second + quarters) <= 1;
        const auto sector = sector_towards(node, before);
        if (!sector) return false;
        const int quads = sector->of_field - quarters;
        if (sector->of_field < sector->quads) return quarters < 0 && quads <= sector->quads;
        // Regular are two quads along a border and four around the end of a feature.
        if (sector->quads == 2 && mesh_.corner(node) < 0) return false;
        if (sector->of_field == 4 && border_neighbours(mesh_, node).size() == 1) return false;
        return quads > 0 && sector->angle >= quads * least_angle &&
               sector->angle <= quads * most_angle;
    }

    /// Paths of at most the reach, which end at borders and singularities.
    [[nodiscard]] geom::ShortestPaths paths_from(int vertex) const {
        return geom::shortest_paths(at(mesh_.vertex_count()), {{vertex, 0.0}},
                                    [&](int v, double length, const auto& reach) {
                                        if (v != vertex && is_end(v)) return;
                                        for (const int w : mesh_.neighbours(v)) {
                                            if (mesh_.is_feature(v, w)) continue;
                                            const double there =
                                                length + (mesh_.point(w) - mesh_.point(v)).norm();
                                            if (there <= reach_) reach(w, there);
                                        }
                                    });
    }

    [[nodiscard]] bool is_end(int v) const { return sectors_.contains(v) || quarters_.contains(v); }

    void add_pairs(int vertex, std::vector<NodePair>& pairs) const {
        const auto paths = paths_from(vertex);
        for (int v = 0; v < mesh_.vertex_count(); ++v) {
            if (v == vertex || std::isinf(paths.length[at(v)]) || !is_end(v)) continue;
            if (has_room(quarters_.at(vertex), v, paths.from[at(v)]))
                pairs.push_back({paths.length[at(v)], vertex, v, paths.path_to(v)});
        }
    }

    /// @return whether it is one afterwards, and nothing else has changed
    bool merge(const NodePair& pair) {
        poll_();
        // Counted counter-clockwise around the singularity: its index goes.
        const double jump = -0.5 * M_PI * quarters_.at(pair.singularity);
        const std::vector<double> turn = angles_.solve(pair.path, jump);
        CrossField turned = field_;
        for (int t = 0; t < mesh_.triangle_count(); ++t) {
            if (!mesh_.alive(t) || turn[at(t)] == 0.0) continue;
            const Vec3 normal = mesh_.area_vector(t).normalized();
            turned.direction[at(t)] =
                Eigen::AngleAxisd(turn[at(t)], normal) * field_.direction[at(t)];
        }
        FieldTopology after = field_topology(mesh_, turned);
        if (after.singularities.size() >= topology_.singularities.size() ||
            after.mismatches.size() > topology_.mismatches.size())
            return false;
        field_ = std::move(turned);
        topology_ = std::move(after);
        return true;
    }

    const geom::EditableMesh& mesh_;
    CrossField& field_;
    FieldTopology& topology_;
    double reach_;
    Poll& poll_;
    HarmonicAngles angles_;
    std::map<int, int> quarters_;                      ///< of singularities, by vertex
    std::map<int, std::vector<FieldSector>> sectors_;  ///< by vertex
};

}  // namespace

void merge_singularities(const geom::EditableMesh& mesh, CrossField& field, FieldTopology& topology,
                         double reach_mm, Poll& poll) {
    SingularityMerger(mesh, field, topology, reach_mm, poll).run();
}

}  // namespace patchwright::cage
