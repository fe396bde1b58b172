#include "fit/loop/spacing.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::fit {

namespace {

using mesh::CornerId;
using mesh::EdgeId;
using mesh::Topology;
using mesh::VertexId;

// Between neighbouring edges, of what lengths have changed by. One strip of half the width makes
// a fit's normals about twice as bad (spacing_test).
constexpr double max_ratio = 1.3;
// Sweeps end when no edge changes by more than this share of its length.
constexpr double converged_share = 0.01;
constexpr int max_sweeps = 60;

/// A vertex between two edges of a line.
struct Joint {
    VertexId at;
    std::array<VertexId, 2> ends;
    std::array<EdgeId, 2> edges;
};

/// Joints of one vertex: two where lines cross, one on a crease, or none where it stays.
std::vector<Joint> joints_at(const Topology& t, VertexId v) {
    if (t.is_pinned(v) || t.sharpness(v) > 0.0) return {};
    std::vector<VertexId> ends;
    std::vector<EdgeId> edges;
    const CornerId first = t.corner(v);
    for (CornerId c = first;;) {
        ends.push_back(t.vertex(t.next(c)));
        edges.push_back(t.edge(c));
        const CornerId last = t.previous(c);
        c = t.rotate(c);
        if (c == first) break;
        if (c.valid()) continue;
        ends.push_back(t.vertex(last));
        edges.push_back(t.edge(last));
        break;
    }
    std::vector<std::size_t> sharp;
    for (std::size_t i = 0; i < edges.size(); ++i)
        if (t.sharpness(edges[i]) > 0.0) sharp.push_back(i);
    const auto joint = [&](std::size_t a, std::size_t b) {
        return Joint{v, {ends[a], ends[b]}, {edges[a], edges[b]}};
    };
    if (sharp.size() == 2) return {joint(sharp[0], sharp[1])};
    if (sharp.empty() && edges.size() == 4) return {joint(0, 2), joint(1, 3)};
    return {};
}

/// The change of each edge's logarithm of length since the split: what two neighbours differ by too
/// much, each gives half of.
std::vector<double> graded_changes(const std::vector<Joint>& joints,
                                   const std::vector<int>& halvings) {
    std::vector<double> changes;
    for (const int count : halvings) changes.push_back(-std::log(2.0) * count);
    for (int sweep = 0; sweep < max_sweeps; ++sweep) {
        double most = 0.0;
        for (const Joint& joint : joints) {
            double& a = changes[joint.edges[0].index()];
            double& b = changes[joint.edges[1].index()];
            const double excess = std::abs(a - b) - std::log(max_ratio);
            if (excess <= 0.0) continue;
            most = std::max(most, excess);
            const double share = std::copysign(0.5 * excess, a - b);
            a -= share;
            b += share;
        }
        if (most < converged_share) break;
    }
    return changes;
}

/// Moves vertices along their lines towards where edges have the wanted lengths, or the same ratio.
/// @return the largest move, as a share of the shorter edge beside the vertex
double move_towards(const std::vector<double>& wanted, const std::vector<Joint>& joints,
                    geom::Points& points) {
    constexpr double damping = 0.5;  // where lines cross two moves add up
    const geom::Points now = points;
    double most = 0.0;
    for (const Joint& joint : joints) {
        const Eigen::RowVector3d at = now.row(joint.at.value);
        const Eigen::RowVector3d to_a = now.row(joint.ends[0].value) - at;
        const Eigen::RowVector3d to_b = now.row(joint.ends[1].value) - at;
        const double a = to_a.norm(), b = to_b.norm();
        if (!(a > 0.0) || !(b > 0.0)) continue;
        const double wanted_a = wanted[joint.edges[0].index()];
        const double wanted_b = wanted[joint.edges[1].index()];
        const double move = damping * (wanted_a / (wanted_a + wanted_b) * (a + b) - a);
        points.row(joint.at.value) += move > 0.0 ? to_b * (move / b) : to_a * (-move / a);
        most = std::max(most, std::abs(move) / std::min(a, b));
    }
    return most;
}

}  // namespace

void grade_spacing(mesh::Cage& cage, const std::vector<int>& halvings,
                   const std::vector<VertexId>& held) {
    const Topology& t = *cage.topology;
    std::vector<Joint> joints;
    for (const VertexId v : t.vertices())
        if (std::find(held.begin(), held.end(), v) == held.end())
            for (const Joint& joint : joints_at(t, v))
                if (std::max(halvings[joint.edges[0].index()], halvings[joint.edges[1].index()]) <
                    2)
                    joints.push_back(joint);
    const std::vector<double> changes = graded_changes(joints, halvings);
    std::vector<double> wanted;
    for (const EdgeId e : t.edges()) {
        const double length =
            (cage.points.row(t.end(e).value) - cage.points.row(t.start(e).value)).norm();
        wanted.push_back(length * std::exp2(halvings[e.index()]) * std::exp(changes[e.index()]));
    }
    for (int sweep = 0; sweep < max_sweeps; ++sweep)
        if (move_towards(wanted, joints, cage.points) < converged_share) break;
}

}  // namespace patchwright::fit
