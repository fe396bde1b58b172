#include "adapt/forest_of_plan.h"

#include <patchwright/grid/evaluate.h>

#include <map>

namespace patchwright::adapt {

namespace {

using mesh::VertexId;

/// Points and edges along one edge of blocks, or the side of a block.
struct Run {
    std::vector<std::int32_t> points;
    std::vector<std::int32_t> edges;
    std::vector<bool> reversed;  ///< the edge runs against the run
};

class Builder {
  public:
    explicit Builder(const grid::Plan& plan)
        : plan_(plan), evaluator_(plan), runs_(plan.edges.size()) {}

    PlanForest build() {
        for (std::size_t b = 0; b < plan_.layout.blocks.size(); ++b) add_block(int(b));
        result_.forest.mark_border();
        result_.roots = static_cast<std::int32_t>(result_.forest.quads().size());
        result_.points = Eigen::Map<const geom::Points>(coordinates_.data(),
                                                        Eigen::Index(coordinates_.size() / 3), 3);
        return std::move(result_);
    }

  private:
    std::int32_t add_point(const geom::Vec3& point, const ForestPlace& place) {
        coordinates_.insert(coordinates_.end(), point.begin(), point.end());
        return result_.forest.add_point(place);
    }

    std::int32_t vertex_point(VertexId vertex, const geom::Vec3& point, const ForestPlace& place) {
        const auto [found, is_new] = vertices_.try_emplace(vertex, -1);
        if (is_new) found->second = add_point(point, place);
        return found->second;
    }

    /// Along an edge of blocks, made at its first use.
    /// @param place  of its k-th point
    template <class Place>
    const Run& run_of(int edge, const Place& place) {
        Run& run = runs_[std::size_t(edge)];
        if (!run.points.empty()) return run;
        const grid::EdgePoints& along = plan_.edges[std::size_t(edge)];
        const mesh::Topology& t = *plan_.layout.cage.topology;
        const auto& corners = plan_.layout.edges[std::size_t(edge)].run;
        const int cells = along.cells();
        for (int k = 0; k <= cells; ++k) {
            const geom::Vec3 point = along.points.row(k);
            if (k == 0)
                run.points.push_back(vertex_point(t.vertex(corners.front()), point, place(k)));
            else if (k == cells)
                run.points.push_back(
                    vertex_point(t.vertex(t.next(corners.back())), point, place(k)));
            else
                run.points.push_back(add_point(point, place(k)));
            if (k == 0) continue;
            run.edges.push_back(result_.forest.add_edge(run.points[std::size_t(k) - 1],
                                                        run.points[std::size_t(k)]));
            run.reversed.push_back(false);
        }
        return run;
    }

    static void append(Run& side, const Run& run, bool reversed) {
        const std::size_t n = run.edges.size();
        for (std::size_t k = side.points.empty() ? 0 : 1; k <= n; ++k)
            side.points.push_back(run.points[reversed ? n - k : k]);
        for (std::size_t k = 0; k < n; ++k) {
            side.edges.push_back(run.edges[reversed ? n - 1 - k : k]);
            side.reversed.push_back(run.reversed[reversed ? n - 1 - k : k] != reversed);
        }
    }

    static Run backwards(const Run& run) {
        Run result;
        append(result, run, true);
        return result;
    }

    /// Side 0 and 2 along i, 1 and 3 along j, all rising.
    Run side(int block, std::size_t number, int ni, int nj) {
        const auto place = [&](int n) {  // counter-clockwise
            const int i = number == 0 ? n : number == 1 ? ni - 1 : number == 2 ? ni - 1 - n : 0;
            const int j = number == 0 ? 0 : number == 1 ? n : number == 2 ? nj - 1 : nj - 1 - n;
            return ForestPlace{block,
                               parameters_[std::size_t(i) + std::size_t(ni) * std::size_t(j)]};
        };
        Run run;
        int begin = 0;
        for (const grid::BlockEdgeUse& use :
             plan_.layout.blocks[std::size_t(block)].sides[number]) {
            const int cells = plan_.edges[std::size_t(use.edge)].cells();
            append(
                run,
                run_of(use.edge,
                       [&](int k) { return place(use.reversed ? begin + cells - k : begin + k); }),
                use.reversed);
            begin += cells;
        }
        return number < 2 ? run : backwards(run);
    }

    void add_block(int block) {
        const auto [ni, nj] = plan_.size(block);
        evaluator_.evaluate(block, points_);
        parameters_ = evaluator_.parameters(block);
        std::array<Run, 4> sides;
        for (std::size_t k = 0; k < 4; ++k) sides[k] = side(block, k, ni, nj);
        // Lines of the block: those of constant j, then those of constant i.
        std::vector<Run> rows(static_cast<std::size_t>(nj)), columns(static_cast<std::size_t>(ni));
        rows.front() = sides[0];
        rows.back() = sides[2];
        columns.front() = sides[3];
        columns.back() = sides[1];
        for (int j = 1; j + 1 < nj; ++j) {
            Run& row = rows[std::size_t(j)];
            row.points.push_back(sides[3].points[std::size_t(j)]);
            for (int i = 1; i + 1 < ni; ++i)
                row.points.push_back(
                    add_point(points_.at(i, j), {block, parameters_[points_.index(i, j)]}));
            row.points.push_back(sides[1].points[std::size_t(j)]);
            connect(row);
        }
        for (int i = 1; i + 1 < ni; ++i) {
            Run& column = columns[std::size_t(i)];
            for (const Run& row : rows) column.points.push_back(row.points[std::size_t(i)]);
            connect(column);
        }
        add_quads(block, rows, columns);
    }

    void connect(Run& line) {
        for (std::size_t k = 0; k + 1 < line.points.size(); ++k)
            line.edges.push_back(result_.forest.add_edge(line.points[k], line.points[k + 1]));
        line.reversed.assign(line.edges.size(), false);
    }

    void add_quads(int block, const std::vector<Run>& rows, const std::vector<Run>& columns) {
        for (std::size_t j = 0; j + 1 < rows.size(); ++j) {
            for (std::size_t i = 0; i + 1 < columns.size(); ++i) {
                const auto at = [&](std::size_t di, std::size_t dj) {
                    return parameters_[points_.index(int(i + di), int(j + dj))];
                };
                const Run &low = rows[j], &high = rows[j + 1], &left = columns[i],
                          &right = columns[i + 1];
                result_.forest.add_quad(
                    {.edges = {low.edges[i], right.edges[j], high.edges[i], left.edges[j]},
                     .reversed = {low.reversed[i], right.reversed[j], !high.reversed[i],
                                  !left.reversed[j]},
                     .block = block,
                     .at = {at(0, 0), at(1, 0), at(1, 1), at(0, 1)}});
            }
        }
    }

    const grid::Plan& plan_;
    grid::BlockEvaluator evaluator_;
    PlanForest result_;
    std::vector<double> coordinates_;
    std::map<VertexId, std::int32_t> vertices_;
    std::vector<Run> runs_;  ///< of edges of blocks
    grid::BlockPoints points_;
    std::vector<Eigen::Vector2d> parameters_;
};

}  // namespace

PlanForest forest_of_plan(const grid::Plan& plan) { return Builder(plan).build(); }

}  // namespace patchwright::adapt
