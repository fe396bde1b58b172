#include "grid/edge_curve.h"
#include "grid/line_classes.h"
#include "grid/line_density.h"
#include "grid/line_ends.h"
#include "grid/memory.h"
#include "grid/moved_points.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/grid/plan.h>
#include <patchwright/subd/refine.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace patchwright::grid {

namespace {

// Above this a typing mistake is likelier than a wish.
constexpr int most_cells = 1 << 20;
// Of a line: more than this is not a first cell.
constexpr double largest_end = 0.4;

int rounded_up(double cells, int levels) {
    const double unit = std::ldexp(1.0, levels);
    const double count = std::max(1.0, std::ceil(cells / unit * (1.0 - 1e-12))) * unit;
    if (!(count <= most_cells)) {
        throw base::UsageError(
            fmt::format("a block edge would have {:.3g} cells; use larger ones", count));
    }
    return static_cast<int>(count);
}

void check(const BlockLayout& layout, const PlanOptions& options) {
    if (!(options.size_mm >= 0.0) || !(options.first_at_creases_mm >= 0.0)) {
        throw base::InvalidArgument("sizes of cells must not be negative");
    }
    if (options.cells < 1 || options.cells > most_cells) {
        throw base::InvalidArgument(
            fmt::format("{} cells on an edge; use 1 to {}", options.cells, most_cells));
    }
    if (options.levels < 0 || options.levels > 16) {
        throw base::InvalidArgument(fmt::format("{} levels; use 0 to 16", options.levels));
    }
    std::set<std::string> families{""};
    for (const Block& block : layout.blocks) families.insert(block.family);
    for (const BorderCluster& cluster : options.clusters) {
        for (const std::string& family : {cluster.family_a, cluster.family_b}) {
            if (families.contains(family)) continue;
            std::string known;
            for (const std::string& name : families) known += (known.empty() ? "" : " ") + name;
            throw base::UsageError(
                fmt::format("no block is of the family '{}'; there are: {}", family, known));
        }
        if (!(cluster.first_mm > 0.0)) {
            throw base::UsageError(fmt::format("the first cell off {}:{} must be above 0",
                                               cluster.family_a, cluster.family_b));
        }
    }
    for (const EdgeRule& rule : options.rules) {
        if (rule.edge < 0 || rule.edge >= static_cast<int>(layout.edges.size())) {
            throw base::InvalidArgument(fmt::format("edge {} does not exist; there are {}",
                                                    rule.edge, layout.edges.size()));
        }
        if (rule.cells && (*rule.cells < 1 || *rule.cells > most_cells)) {
            throw base::UsageError(
                fmt::format("edge {}: {} cells; use 1 to {}", rule.edge, *rule.cells, most_cells));
        }
    }
}

/// Lengths along one edge, and what its points are spread by.
class EdgeLengths {
  public:
    EdgeLengths(const subd::LimitEvaluator& limit, const mesh::Cage& cage, const BlockEdge& edge)
        : curve_(limit, cage, edge),
          arc_([this](double t) { return curve_.derivatives(t).first.norm(); }, curve_.breaks()) {}
    EdgeLengths(const EdgeLengths&) = delete;
    EdgeLengths& operator=(const EdgeLengths&) = delete;

    [[nodiscard]] const EdgeCurve& curve() const { return curve_; }
    [[nodiscard]] const Cumulative& arc() const { return arc_; }

    [[nodiscard]] Cumulative by_curvature() const {
        const auto curvature = [this](double t) {
            const EdgeCurve::Derivatives d = curve_.derivatives(t);
            const double speed = d.first.norm();
            if (speed == 0.0) return 0.0;
            const double along = d.first.dot(d.second) / speed;
            return std::sqrt(std::max(0.0, d.second.squaredNorm() - along * along)) /
                   (speed * speed);
        };
        const double mean =
            Cumulative([&](double t) { return 1e-300 + curvature(t) * speed(t); }, curve_.breaks())
                .total() /
            arc_.total();
        // Straight, but for rounding.
        if (mean * arc_.total() < 1e-9) return arc_;
        return {[this, curvature, mean](double t) {
                    return speed(t) * std::sqrt(0.1 + curvature(t) / mean);
                },
                curve_.breaks()};
    }

  private:
    [[nodiscard]] double speed(double t) const { return curve_.derivatives(t).first.norm(); }

    EdgeCurve curve_;
    Cumulative arc_;
};

/// What one edge gets.
struct EdgeSpec {
    int cells = 1;
    Law law = Law::Uniform;
    Ends ends;
    const LineDensity* density = nullptr;
    bool reversed_density = false;
};

/// What points are spread by along an edge, from 0 at its start to 1 at its end.
struct Share {
    std::function<double(double t)> at;
    std::function<double(double share)> inverse;
};

Share share_of(const EdgeLengths& measure, const EdgeSpec& spec, Measure by) {
    const Cumulative& arc = measure.arc();
    if (spec.density != nullptr) {
        const LineDensity& density = *spec.density;
        const bool reversed = spec.reversed_density;
        return {[&arc, &density, reversed](double t) {
                    return density.before(arc.at(t) / arc.total(), reversed) / density.cells();
                },
                [&arc, &density, reversed](double share) {
                    return arc.inverse(density.fraction(share * density.cells(), reversed) *
                                       arc.total());
                }};
    }
    const auto weighted =
        std::make_shared<Cumulative>(by == Measure::Curvature ? measure.by_curvature() : arc);
    return {[weighted](double t) { return weighted->at(t) / weighted->total(); },
            [weighted](double share) { return weighted->inverse(share * weighted->total()); }};
}

void place_points(const EdgeLengths& measure, const EdgeSpec& spec, Measure by, EdgePoints& edge) {
    const Cumulative& arc = measure.arc();
    const Share share = share_of(measure, spec, by);
    // A cell's size as a share, so that the law meets it there.
    const auto end_share = [&](double size_mm, bool at_end) {
        if (size_mm == 0.0) return 0.0;
        const double s = std::min(size_mm, largest_end * arc.total());
        const double w = share.at(arc.inverse(at_end ? arc.total() - s : s));
        return std::min(at_end ? 1.0 - w : w, largest_end);
    };
    const std::vector<double> s =
        fractions(spec.law, spec.cells,
                  {end_share(spec.ends.first_mm, false), end_share(spec.ends.last_mm, true)});
    edge.parameters.assign(s.size(), 0.0);
    for (std::size_t k = 1; k + 1 < s.size(); ++k) edge.parameters[k] = share.inverse(s[k]);
    edge.parameters.back() = measure.curve().end();
}

void evaluate_points(const EdgeCurve& curve, EdgePoints& edge, const geom::Vec3& start,
                     const geom::Vec3& end) {
    const auto count = Eigen::Index(edge.parameters.size());
    edge.points.resize(count, 3);
    edge.points.row(0) = start;
    edge.points.row(count - 1) = end;
    for (Eigen::Index k = 1; k + 1 < count; ++k) {
        edge.points.row(k) = curve.at(edge.parameters[std::size_t(k)]);
    }
}

/// The limit points where edges end, each once.
std::map<mesh::VertexId, geom::Vec3> corner_points(const BlockLayout& layout,
                                                   const subd::LimitEvaluator& limit) {
    const mesh::Topology& t = *layout.cage.topology;
    std::map<mesh::VertexId, geom::Vec3> points;
    for (const BlockEdge& edge : layout.edges) {
        for (const mesh::VertexId v :
             {t.vertex(edge.run.front()), t.vertex(t.next(edge.run.back()))}) {
            if (!points.contains(v)) {
                points[v] =
                    limit.position(layout.cage.points, subd::corner_location(t, t.corner(v)));
            }
        }
    }
    return points;
}

/// Law and sizes, of one edge or of all that lines connect to it.
void apply_rule(const EdgeRule& rule, const LineClasses& classes, std::vector<EdgeSpec>& specs) {
    const LineClasses::Member& own = classes.edges[std::size_t(rule.edge)];
    for (std::size_t e = 0; e < specs.size(); ++e) {
        const LineClasses::Member& member = classes.edges[e];
        const bool is_meant =
            rule.connected ? member.line_class == own.line_class : e == std::size_t(rule.edge);
        if (!is_meant) continue;
        const bool turned = member.reversed != own.reversed;
        EdgeSpec& spec = specs[e];
        if (rule.law) spec.law = *rule.law;
        if (rule.first_mm) (turned ? spec.ends.last_mm : spec.ends.first_mm) = *rule.first_mm;
        if (rule.last_mm) (turned ? spec.ends.first_mm : spec.ends.last_mm) = *rule.last_mm;
    }
}

std::vector<EdgeSpec> edge_specs(const BlockLayout& layout, const LineClasses& classes,
                                 const std::vector<LineDensity>& densities,
                                 const std::vector<double>& lengths, const PlanOptions& options) {
    std::vector<EdgeSpec> specs(layout.edges.size());
    std::vector<Ends> ends = ends_at_borders(layout, options);
    share_ends(classes, ends);
    std::vector<double> cells(std::size_t(classes.count()), 0.0);
    for (std::size_t e = 0; e < specs.size(); ++e) {
        const auto c = std::size_t(classes.edges[e].line_class);
        specs[e].law = options.law;
        specs[e].ends = ends[e];
        if (!densities.empty()) {
            specs[e].density = &densities[c];
            specs[e].reversed_density = classes.edges[e].reversed;
            cells[c] = densities[c].cells();
        } else {
            cells[c] = std::max(cells[c], options.size_mm > 0.0 ? lengths[e] / options.size_mm
                                                                : double(options.cells));
        }
    }
    std::vector<int> ruled(cells.size(), 0);
    for (const EdgeRule& rule : options.rules) {
        apply_rule(rule, classes, specs);
        if (!rule.cells) continue;
        int& known = ruled[std::size_t(classes.edges[std::size_t(rule.edge)].line_class)];
        if (known != 0 && known != *rule.cells) {
            throw base::UsageError(
                fmt::format("edge {}: {} cells, but an edge that must match it has {}", rule.edge,
                            *rule.cells, known));
        }
        known = *rule.cells;
    }
    for (std::size_t e = 0; e < specs.size(); ++e) {
        const auto c = std::size_t(classes.edges[e].line_class);
        specs[e].cells = ruled[c] != 0 ? ruled[c] : rounded_up(cells[c], options.levels);
    }
    return specs;
}

/// Of the points on edges, and of the largest block while it is written.
void check_memory(const BlockLayout& layout, const std::vector<EdgeSpec>& specs) {
    constexpr double edge_point = 5 * sizeof(double);  // parameter, share and position
    double edge_points = 0.0, points = 0.0, largest = 0.0;
    for (const EdgeSpec& spec : specs) edge_points += spec.cells + 1;
    for (const Block& block : layout.blocks) {
        double size = 1.0;
        for (const std::size_t side : {0U, 1U}) {
            double along = 1.0;
            for (const auto& use : block.sides[side]) along += specs[std::size_t(use.edge)].cells;
            size *= along;
        }
        points += size;
        largest = std::max(largest, size);
    }
    require_memory(points, edge_points * edge_point + largest * block_point_bytes);
}

}  // namespace

std::array<int, 2> Plan::size(int block) const {
    const Block& b = layout.blocks.at(std::size_t(block));
    std::array<int, 2> points{1, 1};
    for (const std::size_t side : {0U, 1U}) {
        for (const BlockEdgeUse& use : b.sides[side]) {
            points[side] += edges[std::size_t(use.edge)].cells();
        }
    }
    return points;
}

std::int64_t Plan::point_count() const {
    std::int64_t count = 0;
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
        const auto [ni, nj] = size(int(b));
        count += std::int64_t(ni) * nj;
    }
    return count;
}

std::int64_t Plan::cell_count() const {
    std::int64_t count = 0;
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
        const auto [ni, nj] = size(int(b));
        count += std::int64_t(ni - 1) * (nj - 1);
    }
    return count;
}

Plan make_plan(const BlockLayout& layout, const PlanOptions& options) {
    check(layout, options);
    const subd::LimitEvaluator limit(layout.cage.topology);
    const LineClasses classes = line_classes(layout);
    std::vector<LineDensity> densities;
    if (options.size) densities = line_densities(layout, classes, options.size);

    std::vector<std::unique_ptr<EdgeLengths>> measures(layout.edges.size());
    std::vector<double> lengths(layout.edges.size());
    base::parallel_for(measures.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t e = first; e < last; ++e) {
            measures[e] = std::make_unique<EdgeLengths>(limit, layout.cage, layout.edges[e]);
            lengths[e] = measures[e]->arc().total();
        }
    });
    for (std::size_t e = 0; e < lengths.size(); ++e) {
        if (lengths[e] > 0.0) continue;
        throw base::InputError(fmt::format(
            "block edge {} has no length: its control points coincide; correct the cage", e));
    }
    const auto specs = edge_specs(layout, classes, densities, lengths, options);
    check_memory(layout, specs);
    const auto corners = corner_points(layout, limit);
    const mesh::Topology& t = *layout.cage.topology;
    Plan plan{layout, std::vector<EdgePoints>(layout.edges.size()), {}};
    base::parallel_for(measures.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t e = first; e < last; ++e) {
            EdgePoints& edge = plan.edges[e];
            edge.length_mm = lengths[e];
            place_points(*measures[e], specs[e], options.measure, edge);
            const auto& run = layout.edges[e].run;
            evaluate_points(measures[e]->curve(), edge, corners.at(t.vertex(run.front())),
                            corners.at(t.vertex(t.next(run.back()))));
        }
    });
    return plan;
}

Plan with_points(const Plan& plan, const geom::Points& points) {
    const std::shared_ptr<const mesh::Topology>& given = plan.layout.given;
    if (points.rows() != given->vertex_count())
        throw base::InvalidArgument(fmt::format("{} points for a cage of {} vertices",
                                                points.rows(), given->vertex_count()));
    Plan result = plan;
    mesh::Cage& cage = result.layout.cage;
    cage.points =
        cage.topology == given ? points : subd::refine(mesh::Cage{given, points}, 1).points;
    if (!result.moved.empty()) {
        evaluate_moved_edges(result);
        return result;
    }
    const subd::LimitEvaluator limit(cage.topology);
    const auto corners = corner_points(result.layout, limit);
    const mesh::Topology& t = *cage.topology;
    base::parallel_for(result.edges.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t e = first; e < last; ++e) {
            const BlockEdge& along = result.layout.edges[e];
            const EdgeLengths lengths(limit, cage, along);
            result.edges[e].length_mm = lengths.arc().total();
            evaluate_points(lengths.curve(), result.edges[e],
                            corners.at(t.vertex(along.run.front())),
                            corners.at(t.vertex(t.next(along.run.back()))));
        }
    });
    return result;
}

}  // namespace patchwright::grid
