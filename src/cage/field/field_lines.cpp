#include "cage/field/field_lines.h"

#include "cage/blocks/layout_refused.h"
#include "cage/field/field_nodes.h"
#include "cage/field/line_drawing.h"
#include "cage/field/line_sectors.h"
#include "cage/field/ring_cuts.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// How far a line between two nodes may leave the field, radians (20 degrees), and by how much it
// counts as twice as long.
constexpr double most_deviation = 0.35, deviation_unit = 0.15;
// Nodes that are tried from a port, nearest to its line first, and tries to hit one.
constexpr int most_targets = 6, aiming_steps = 6;
// Length of a line by its distance from the node that it began at, above which it comes back there.
constexpr double return_ratio = 2.0;
// A node is no target where the line's triangle is off its level by more than this share of the
// way: it is on another sheet.
constexpr double off_level = 0.5;
// Share of a connection's length from its end at which it is compared with the lines from the ports
// there, and how much nearer one of them must be than the others.
constexpr double compared_share = 0.3, nearer_than_others = 0.7;
// Times that a line may come back to where it was; from the third time on it goes straight into
// itself or another line instead of nearer and nearer to itself.
constexpr int most_turns = 30, turns_along_field = 2;

/// A way to connect a port with a node.
struct Connection {
    double cost = 0.0;
    int port = -1, node = -1;
    double deviation = 0.0;
};

/// Where a line passes a node: to its left at a positive angle.
struct Miss {
    double angle = 0.0, length = 0.0;
};

class LineMaker {
  public:
    LineMaker(LinedMesh& lined, const FieldTopology& topology, Poll& poll)
        : lined_(lined), nodes_(field_nodes(lined, topology)), poll_(poll) {
        for (const int v : nodes_.vertex) node_points_.push_back(lined.mesh().point(v));
    }

    void run() {
        for (const int v : nodes_.vertex) lined_.set_on_wall(v);
        connect();
        go_on();
        for (const LineStart& start : ring_cuts(lined_)) draw_to_wall(start);
    }

  private:
    [[nodiscard]] const Vec3& node_point(int node) const { return node_points_[at(node)]; }

    /// Whether a line from a node went away from it before this step.
    [[nodiscard]] bool has_returned(int node, const Vec3& from, double before) const {
        return before > return_ratio * (node_point(node) - from).norm();
    }

    /// A line's way through a triangle.
    struct Step {
        Vec3 from, way;
        double before, length;  ///< of the line before it, and its own
        Vec3 normal, aside;     ///< of the triangle, and what is across the way in it
    };
    [[nodiscard]] Step step_in(int triangle, const Vec3& from, const Vec3& to,
                               double before) const {
        const Vec3 way = to - from;
        const Vec3 normal = lined_.mesh().area_vector(triangle).normalized();
        return {from, way, before, way.norm(), normal, normal.cross(way)};
    }

    /// How a step of a line passes a node; nothing where it does not pass it.
    [[nodiscard]] std::optional<Miss> miss_of(int node, const Step& step) const {
        if (!(step.length > 0.0)) return std::nullopt;
        const Vec3 offset = node_point(node) - step.from;
        const double along = offset.dot(step.way) / step.length;
        if (along < 0.0 || along > step.length) return std::nullopt;
        const double aside = step.aside.dot(offset) / step.length;
        const double total = step.before + along;
        if (std::abs(aside) > 2.0 * most_deviation * total ||
            std::abs(step.normal.dot(offset)) > off_level * std::max(std::abs(aside), step.length))
            return std::nullopt;
        return Miss{std::atan2(aside, total), total};
    }

    [[nodiscard]] static double cost_of(double length, double deviation) {
        return length * (1.0 + std::pow(deviation / deviation_unit, 2.0));
    }

    /// The nodes that a port's line passes, and how.
    [[nodiscard]] std::vector<Connection> targets_of(int p) {
        const Port& port = nodes_.ports[at(p)];
        paths_[at(p)] = {node_point(port.node)};
        std::map<int, Miss> near;
        bool returned = false;
        trace_line(lined_, port.start, {.crosses_lines = true, .passes = 2}, poll_,
                   [&](int t, const Vec3& from, const Vec3& to, double before) {
                       paths_[at(p)].push_back(to);
                       // Beyond where it comes back past its beginning it goes round and round.
                       if (returned) return;
                       const Step step = step_in(t, from, to, before);
                       for (int n = 0; n < int(nodes_.vertex.size()); ++n) {
                           if (n == port.node && !has_returned(n, from, before)) continue;
                           const auto miss = miss_of(n, step);
                           if (!miss || std::abs(miss->angle) > most_deviation) continue;
                           returned = returned || n == port.node;
                           const auto [it, added] = near.emplace(n, *miss);
                           if (!added && std::abs(miss->angle) < std::abs(it->second.angle))
                               it->second = *miss;
                       }
                   });
        std::vector<Connection> result;
        for (const auto& [n, miss] : near)
            result.push_back({cost_of(miss.length, miss.angle), p, n, miss.angle});
        std::sort(result.begin(), result.end(), cheaper);
        if (int(result.size()) > most_targets) result.resize(at(most_targets));
        return result;
    }

    static bool cheaper(const Connection& a, const Connection& b) {
        return std::tie(a.cost, a.port, a.node) < std::tie(b.cost, b.port, b.node);
    }

    /// A line from a port to a node; aims better and better. Sets the deviation and the cost.
    [[nodiscard]] std::optional<TracedLine> aimed(Connection& c) {
        const Port& port = nodes_.ports[at(c.port)];
        const int target = nodes_.vertex[at(c.node)];
        std::vector<char> meets(at(lined_.mesh().vertex_count()), 0);
        meets[at(target)] = 1;
        double last = base::infinity;
        for (int i = 0; i < aiming_steps; ++i) {
            std::optional<Miss> miss;
            TracedLine line =
                trace_line(lined_, port.start,
                           {.deviation = c.deviation, .crosses_lines = true, .meets = &meets},
                           poll_, [&](int t, const Vec3& from, const Vec3& to, double before) {
                               if (c.node == port.node && !has_returned(c.node, from, before))
                                   return;
                               const auto m = miss_of(c.node, step_in(t, from, to, before));
                               if (m && (!miss || std::abs(m->angle) < std::abs(miss->angle)))
                                   miss = m;
                           });
            if (line.end == LineEnd::Vertex) {
                const Vec3 here =
                    line.points.empty() ? node_point(port.node) : lined_.point(line.points.back());
                c.cost = cost_of(line.length + (node_point(c.node) - here).norm(), c.deviation);
                return line;
            }
            if (!miss || std::abs(miss->angle) >= last) return std::nullopt;
            last = std::abs(miss->angle);
            c.deviation += miss->angle;
            if (std::abs(c.deviation) > most_deviation) return std::nullopt;
        }
        return std::nullopt;
    }

    /// The point of a path at a length from its beginning.
    [[nodiscard]] static Vec3 point_after(const std::vector<Vec3>& path, double length) {
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
            const double step = (path[i + 1] - path[i]).norm();
            if (step >= length && step > 0.0)
                return path[i] + length / step * (path[i + 1] - path[i]);
            length -= step;
        }
        return path.back();
    }

    /// The free port that a line arrives at, the one whose own line is nearest; -1: none.
    [[nodiscard]] int arrival(const Connection& c, const TracedLine& line) const {
        std::vector<Vec3> path{node_point(c.node)};
        for (std::size_t i = line.points.size(); i-- > 0;)
            path.push_back(lined_.point(line.points[i]));
        path.push_back(node_point(nodes_.ports[at(c.port)].node));
        const double share = compared_share * (line.length + (path[0] - path[1]).norm());
        const Vec3 here = point_after(path, share);
        int best = -1;
        double least = base::infinity, second = base::infinity;
        for (const int p : nodes_.ports_of[at(c.node)]) {
            const double distance = (point_after(paths_[at(p)], share) - here).norm();
            second = std::min(second, std::max(distance, least));
            if (distance >= least) continue;
            least = distance;
            best = p;
        }
        const bool clear = least < nearer_than_others * second;
        return clear && best != c.port && !nodes_.ports[at(best)].used ? best : -1;
    }

    void connect() {
        std::vector<Connection> targets, all;
        paths_.resize(nodes_.ports.size());
        for (int p = 0; p < int(nodes_.ports.size()); ++p) {
            poll_();
            const auto of_port = targets_of(p);
            targets.insert(targets.end(), of_port.begin(), of_port.end());
        }
        for (Connection& c : targets) {
            poll_();
            const auto line = aimed(c);
            if (line && arrival(c, *line) >= 0) all.push_back(c);
        }
        std::sort(all.begin(), all.end(), cheaper);
        for (Connection& c : all) {
            poll_();
            Port& port = nodes_.ports[at(c.port)];
            if (port.used) continue;
            const auto line = aimed(c);
            if (!line) continue;
            const int end = arrival(c, *line);
            if (end < 0) continue;
            draw_line(lined_, port.start.vertex, *line, lined_.add_line());
            port.used = nodes_.ports[at(end)].used = true;
        }
    }

    /// All other lines, the shortest first.
    void go_on() {
        std::vector<std::pair<double, int>> order;
        for (int p = 0; p < int(nodes_.ports.size()); ++p) {
            poll_();
            if (nodes_.ports[at(p)].used) continue;
            order.emplace_back(trace_line(lined_, nodes_.ports[at(p)].start, {}, poll_).length, p);
        }
        std::sort(order.begin(), order.end());
        for (const auto& [length, p] : order) draw_to_wall(nodes_.ports[at(p)].start);
    }

    void draw_to_wall(LineStart start) {
        int number = -1;
        for (int turn = 0; turn < most_turns; ++turn) {
            poll_();
            const TracedLine line =
                trace_line(lined_, start, {.straight = turn > turns_along_field}, poll_);
            if (line.end == LineEnd::Lost || line.points.empty()) {
                if (number >= 0) throw LayoutRefused{"a line of the field is lost"};
                return;
            }
            if (number < 0) number = lined_.add_line();
            start = {draw_line(lined_, start.vertex, line, number), line.direction};
            if (line.end == LineEnd::Wall) return;
        }
        throw LayoutRefused{"a line of the field turns round and round"};
    }

    LinedMesh& lined_;
    FieldNodes nodes_;
    std::vector<Vec3> node_points_;
    Poll& poll_;
    std::vector<std::vector<Vec3>>
        paths_;  ///< of the lines from the ports, when there are no others
};

}  // namespace

FieldLines field_lines(geom::EditableMesh& mesh, CrossField& field, const FieldTopology& topology,
                       Poll& poll) {
    LinedMesh lined(mesh, field);
    const SectorCounts counts(lined, topology);
    LineMaker(lined, topology, poll).run();
    return {lined.lines(), counts.sectors(lined)};
}

}  // namespace patchwright::cage
