#include "adapt/forest_of_plan.h"
#include "grid/cell_point.h"
#include "grid/memory.h"

#include <patchwright/adapt/local_grid.h>
#include <patchwright/base/parallel.h>

#include <algorithm>

namespace patchwright::adapt {

namespace {

/// Of a point: position, place, and what the quads and edges around it hold, while files are
/// written.
constexpr double local_point_bytes = 2 * sizeof(QuadForest::Edge) +
                                     4.0 / 3.0 * sizeof(QuadForest::Quad) + sizeof(LocalCell) +
                                     sizeof(ForestPlace) + 12 * sizeof(double);

/// Points and sides between looks at whether to stop.
constexpr std::size_t most_at_once = 1 << 16;

class Refiner {
  public:
    Refiner(const grid::Plan& plan, const Criteria& criteria, const grid::RefineOptions& options)
        : plan_(plan),
          limit_(plan.layout.cage.topology),
          error_(refinement_error(criteria)),
          options_(options) {
        require_memory(double(plan.point_count()));
        PlanForest made = forest_of_plan(plan);
        forest_ = std::move(made.forest);
        roots_ = made.roots;
        positions_.assign(made.points.data(), made.points.data() + made.points.size());
        if (criteria.sizes) require_memory(criteria);
    }

    LocalGrid run() {
        std::size_t first = 0;  // of the quads that are new
        for (; level_ < options_.max_rounds; ++level_) {
            const std::vector<std::int32_t> wanted = too_large(first);
            if (wanted.empty()) break;
            first = forest_.quads().size();
            require_memory(double(forest_.places().size() + 3 * wanted.size()));
            for (const std::int32_t quad : wanted) forest_.divide(quad);
            evaluate_points();
        }
        return result();
    }

  private:
    static void require_memory(double points) {
        grid::require_memory(points, points * local_point_bytes);
    }
    /// Before many rounds have made an ever larger grid: for sizes that are small all over a cell.
    void require_memory(const Criteria& criteria) const {
        double cells = 0.0;
        for (std::int32_t q = 0; q < roots_; ++q) {
            double longest = 1.0;  // in sizes
            for (std::size_t k = 0; k < 4; ++k) {
                const geom::Vec3 a = position(forest_.corner(q, k)),
                                 b = position(forest_.corner(q, (k + 1) % 4));
                const double size =
                    std::max({(*criteria.sizes)(a), (*criteria.sizes)(b),
                              (*criteria.sizes)(0.5 * (a + b)), criteria.smallest_mm});
                longest = std::max(longest, (b - a).norm() / size);
            }
            cells += longest * longest;
        }
        require_memory(cells);
    }

    [[nodiscard]] geom::Vec3 position(std::int32_t point) const {
        return geom::Vec3::Map(positions_.data() + 3 * std::size_t(point));
    }

    /// On the layout's cage.
    [[nodiscard]] subd::Location location(const ForestPlace& place) const {
        const grid::CellPoint p =
            grid::cell_point(plan_.layout.blocks[std::size_t(place.block)], place.at);
        return grid::place_in_face(*plan_.layout.cage.topology, p.cell, p.i, p.j);
    }

    /// @param begin  of the places to begin with
    geom::Points evaluated(const std::vector<ForestPlace>& places, std::size_t begin = 0) const {
        geom::Points points(Eigen::Index(places.size() - begin), 3);
        std::vector<std::int32_t> faces;
        std::vector<double> uv;
        for (std::size_t n = begin; n < places.size();) {
            report();
            faces.clear();
            uv.clear();
            const std::size_t first = n;
            for (; n < std::min(places.size(), first + most_at_once); ++n) {
                const subd::Location at = location(places[n]);
                faces.push_back(at.face.value);
                uv.insert(uv.end(), {at.u, at.v});
            }
            points.middleRows(Eigen::Index(first - begin), Eigen::Index(n - first)) =
                limit_.evaluate(plan_.layout.cage.points,
                                {.faces = faces, .uv = uv, .sectors = {}});
        }
        return points;
    }

    void report() const {
        base::report_progress(options_.progress, "grid",
                              double(level_) / double(options_.max_rounds));
    }

    /// Of points that have none.
    void evaluate_points() {
        const geom::Points made = evaluated(forest_.places(), positions_.size() / 3);
        positions_.insert(positions_.end(), made.data(), made.data() + made.size());
    }

    /// Leaves, from a quad on, with a side that is too long.
    std::vector<std::int32_t> too_large(std::size_t first) {
        // Sides that nobody has looked at; those that are divided have their middle.
        std::vector<std::int32_t> sides;
        std::vector<ForestPlace> middles;
        known_.resize(forest_.edges().size(), Unknown);
        for (std::size_t q = first; q < forest_.quads().size(); ++q) {
            if (!forest_.is_leaf(std::int32_t(q))) continue;
            for (std::size_t k = 0; k < 4; ++k) {
                const std::int32_t edge = forest_.quads()[q].edges[k];
                if (known_[std::size_t(edge)] != Unknown) continue;
                known_[std::size_t(edge)] = ShortEnough;
                sides.push_back(edge);
                middles.push_back(forest_.middle(std::int32_t(q), k));
            }
        }
        const geom::Points points = evaluated(middles);
        constexpr std::size_t sides_a_task = 256;
        for (std::size_t begin = 0; begin < sides.size(); begin += most_at_once) {
            report();
            base::parallel_for(std::min(most_at_once, sides.size() - begin), sides_a_task,
                               [&](std::size_t from, std::size_t to) {
                                   for (std::size_t s = begin + from; s < begin + to; ++s) {
                                       const QuadForest::Edge& edge =
                                           forest_.edges()[std::size_t(sides[s])];
                                       if (error_(position(edge.a), position(edge.b),
                                                  points.row(Eigen::Index(s)).transpose()) > 1.0)
                                           known_[std::size_t(sides[s])] = TooLong;
                                   }
                               });
        }
        std::vector<std::int32_t> result;
        for (std::size_t q = first; q < forest_.quads().size(); ++q) {
            const auto& edges = forest_.quads()[q].edges;
            if (forest_.is_leaf(std::int32_t(q)) &&
                std::any_of(edges.begin(), edges.end(), [&](std::int32_t edge) {
                    return known_[std::size_t(edge)] == TooLong;
                }))
                result.push_back(std::int32_t(q));
        }
        return result;
    }

    LocalGrid result() const {
        LocalGrid grid;
        grid.points = Eigen::Map<const geom::Points>(positions_.data(),
                                                     Eigen::Index(positions_.size() / 3), 3);
        set_places(grid.places);
        for (const grid::Block& block : plan_.layout.blocks) {
            grid.block_names.push_back(block.name);
            grid.block_families.push_back(block.family);
        }
        for (std::int32_t root = 0; root < roots_; ++root) add_leaves(root, grid);
        return grid;
    }

    void set_places(grid::BlockPlaces& places) const {
        const std::size_t count = forest_.places().size();
        const bool with_sectors = !plan_.layout.given->all_quads();
        for (std::size_t n = 0; n < count; ++n) {
            const ForestPlace& place = forest_.places()[n];
            const grid::CellPoint p =
                grid::cell_point(plan_.layout.blocks[std::size_t(place.block)], place.at);
            const subd::Location at = grid::place_on_given(plan_.layout, p.cell, p.i, p.j);
            places.faces.push_back(at.face.value);
            places.u.push_back(at.u);
            places.v.push_back(at.v);
            if (with_sectors) places.sectors.push_back(at.sector);
        }
    }

    void add_leaves(std::int32_t quad, LocalGrid& grid) const {
        const QuadForest::Quad& q = forest_.quads()[std::size_t(quad)];
        if (q.child >= 0) {
            for (std::int32_t k = 0; k < 4; ++k) add_leaves(q.child + k, grid);
            return;
        }
        LocalCell cell{.block = q.block, .level = q.level};
        for (std::size_t k = 0; k < 4; ++k) {
            const QuadForest::Edge& edge = forest_.edges()[std::size_t(q.edges[k])];
            cell.corners[k] = forest_.corner(quad, k);
            cell.hanging[k] = edge.middle;
            if (edge.is_border)
                grid.free_sides.push_back({cell.corners[k], forest_.corner(quad, (k + 1) % 4)});
        }
        grid.cells.push_back(cell);
    }

    enum Known : char { Unknown, ShortEnough, TooLong };

    const grid::Plan& plan_;
    subd::LimitEvaluator limit_;
    grid::LineError error_;
    grid::RefineOptions options_;
    QuadForest forest_;
    std::int32_t roots_ = 0;
    int level_ = 0;
    std::vector<double> positions_;
    std::vector<Known> known_;  ///< of edges
};

}  // namespace

int LocalGrid::deepest() const {
    int level = 0;
    for (const LocalCell& cell : cells) level = std::max(level, int(cell.level));
    return level;
}

std::int64_t LocalGrid::hanging_nodes() const {
    std::int64_t count = 0;
    for (const LocalCell& cell : cells)
        count += std::count_if(cell.hanging.begin(), cell.hanging.end(),
                               [](std::int32_t point) { return point >= 0; });
    return count;
}

LocalGrid refined_locally(const grid::Plan& plan, const Criteria& criteria,
                          const grid::RefineOptions& options) {
    return Refiner(plan, criteria, options).run();
}

}  // namespace patchwright::adapt
