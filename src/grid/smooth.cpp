#include "grid/memory.h"
#include "grid/moved_points.h"
#include "grid/plan_subset.h"
#include "grid/sliding_points.h"
#include "grid/smooth_step.h"

#include <patchwright/base/error.h>
#include <patchwright/grid/smooth.h>

#include <algorithm>
#include <numeric>

namespace patchwright::grid {

namespace {

/// A step that does not lower the energy is halved, so often at most.
constexpr int most_halvings = 12;
/// Iterations end when the energy has fallen by less than this share in the last few.
constexpr double settled = 5e-3;
constexpr std::size_t settled_over = 3;
/// Of a point, on all levels: cells, matrix and factors, measured.
constexpr double smoothing_point_bytes = 2000.0;
/// What a cell counts for there at most: folded ones that cannot be mended do not hide the others.
constexpr double most_of_cell = 10.0;

/// Whether two points of one block edge, one after the other, lie on a feature.
class FeatureLines {
  public:
    FeatureLines(const Plan& plan, const FrontMesh& mesh) {
        for (std::size_t e = 0; e < plan.edges.size(); ++e) {
            const auto& numbers = mesh.on_edge(int(e));
            const auto& run = plan.layout.edges[e].run;
            for (std::size_t n = 0; n + 1 < numbers.size(); ++n) {
                const double middle =
                    0.5 * (plan.edges[e].parameters[n] + plan.edges[e].parameters[n + 1]);
                const auto k = std::min(std::size_t(middle), run.size() - 1);
                if (is_feature(*plan.layout.cage.topology, run[k]))
                    lines_.push_back(line(numbers[n], numbers[n + 1]));
            }
        }
        std::sort(lines_.begin(), lines_.end());
    }
    [[nodiscard]] bool operator()(std::int32_t p, std::int32_t q) const {
        return std::binary_search(lines_.begin(), lines_.end(), line(p, q));
    }

  private:
    using Line = std::pair<std::int32_t, std::int32_t>;
    static Line line(std::int32_t p, std::int32_t q) { return {std::min(p, q), std::max(p, q)}; }

    std::vector<Line> lines_;
};

double sum_of(const std::vector<double>& energies) {
    return std::accumulate(energies.begin(), energies.end(), 0.0);
}

/// One level of a cascade from coarse grids to fine ones.
class Level {
  public:
    /// @pre the plan outlives this
    explicit Level(const Plan& plan)
        : plan_(plan),
          mesh_(plan),
          cells_(plan, mesh_, FeatureLines(plan, mesh_)),
          sliding_(plan, mesh_),
          points_(mesh_.surface()) {}

    void run(const SmoothOptions& options) {
        const KeptPoints kept = every_second(plan_);
        const Plan coarser = subset(plan_, kept);
        if (2 * coarser.cell_count() <= plan_.cell_count()) {
            Level below(coarser);
            below.run(options);
            follow(below, kept);
        }
        descend(options);
    }

    [[nodiscard]] std::vector<subd::Location> places(int block) const {
        std::vector<subd::Location> result;
        for (const std::int32_t p : mesh_.numbers(block))
            result.push_back(sliding_.location(std::size_t(p)));
        return result;
    }

  private:
    /// Newton's method with steps halved where necessary.
    void descend(const SmoothOptions& options) {
        SmoothStep solver(cells_, sliding_.freedom());
        std::vector<SmoothCells::Basis> bases;
        std::vector<double> values;
        for (int k = 0; k < options.iterations; ++k) {
            base::report_progress(options.progress, "smooth", double(k) / options.iterations);
            cells_.measure_normals(points_);
            cells_.energies(points_, energies_);
            double value = 0.0;
            for (const double energy : energies_) value += std::min(energy, most_of_cell);
            values.push_back(value);
            if (values.size() > settled_over) {
                const double past = values[values.size() - 1 - settled_over];
                if (past - value < settled * past) break;
            }
            sliding_.measure_bases(cells_.point_normals(), bases);
            geom::Points by = solver.solve(points_, bases);
            if (by.isZero(0.0) || !by.allFinite()) break;
            int halvings = 0;
            while (!moves(by) && halvings < most_halvings) {
                by *= 0.5;
                ++halvings;
            }
            if (halvings == most_halvings) break;
        }
    }

    /// Moves all points if that lowers the energy.
    bool moves(const geom::Points& by) {
        sliding_.move(by, moved_);
        cells_.energies(moved_.points, next_energies_);
        if (!(sum_of(next_energies_) < sum_of(energies_))) return false;
        points_.swap(moved_.points);
        sliding_.accept(moved_);
        return true;
    }

    /// Moves all points as those of the coarser grid have moved, linearly between them; not where
    /// that is worse, as where the coarser grid's cells cut through a nose.
    void follow(const Level& below, const KeptPoints& kept) {
        const geom::Points way = below.points_ - below.mesh_.surface();
        geom::Points by(points_.rows(), 3);
        for (int b = 0; b < int(plan_.layout.blocks.size()); ++b) {
            const auto at_i = between(kept_along(plan_.layout, kept, b, 0));
            const auto at_j = between(kept_along(plan_.layout, kept, b, 1));
            const auto width = std::size_t(below.plan_.size(b)[0]);
            const auto moved = [&](int i, int j) {
                return way.row(below.mesh_.numbers(b)[std::size_t(i) + width * std::size_t(j)]);
            };
            for (std::size_t j = 0; j < at_j.size(); ++j) {
                for (std::size_t i = 0; i < at_i.size(); ++i) {
                    const auto [m, s] = at_i[i];
                    const auto [n, t] = at_j[j];
                    by.row(mesh_.numbers(b)[i + at_i.size() * j]) =
                        (1 - t) * ((1 - s) * moved(m, n) + s * moved(m + 1, n)) +
                        t * ((1 - s) * moved(m, n + 1) + s * moved(m + 1, n + 1));
                }
            }
        }
        cells_.measure_normals(points_);
        cells_.energies(points_, energies_);
        moves(by);
    }

    const Plan& plan_;
    FrontMesh mesh_;
    SmoothCells cells_;
    SlidingPoints sliding_;
    geom::Points points_;
    std::vector<double> energies_, next_energies_;  ///< of cells
    SlidingPoints::Moved moved_;
};

}  // namespace

Plan smoothed(const Plan& plan, const SmoothOptions& options) {
    if (!plan.moved.empty()) throw base::InvalidArgument("the plan is smoothed already");
    const auto points = double(plan.point_count());
    require_memory(points, points * smoothing_point_bytes);
    Level level(plan);
    level.run(options);
    Plan result = plan;
    for (int b = 0; b < int(plan.layout.blocks.size()); ++b)
        result.moved.push_back(level.places(b));
    evaluate_moved_edges(result);
    return result;
}

}  // namespace patchwright::grid
