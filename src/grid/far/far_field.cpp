#include "grid/far/far_field.h"

#include "grid/far/shell_step.h"
#include "grid/memory.h"
#include "grid/plan_subset.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace patchwright::grid {

namespace {

using geom::Points;
using geom::Vec3;

/// The cascade ends with so many cells of a front, and so many fronts.
constexpr std::int64_t coarse_cells = 300;
constexpr int coarse_fronts = 8;
/// Least e of the energy; else the worst fold's determinant.
constexpr double least_e = 1e-3;
constexpr int most_iterations = 60, most_halvings = 15;
/// On the finest level, which begins near its solution and takes most of the time: more would be
/// spent on folds that stay, as over a surface that is folded.
constexpr int most_finest_iterations = 20;
/// Iterations end when the energy falls by less than this share, and the least determinant is this
/// or rises by less than that share.
constexpr double settled = 5e-3, good_determinant = 0.01, settled_determinant = 0.2;
/// They also end when the least determinant has stayed below this share of what it was, so often.
constexpr double share_of_progress = 0.97;
constexpr int most_stuck = 3;
/// Rounds in which points are spread on the sphere before the coarsest grid is smoothed.
constexpr int spreading_rounds = 30;
/// Of a point: position, step, derivatives and factors on all levels, measured.
constexpr double point_bytes = 700.0;

Vec3 at(const Points& points, std::size_t row) { return points.row(Eigen::Index(row)).transpose(); }

/// Growth with which cells that begin with a height fill a length.
double growth_to_fill(double length, double height, int cells) {
    double low = 0.1, high = 10.0;
    for (int step = 0; step < 60; ++step) {
        const double g = std::sqrt(low * high);
        double sum = 0.0, cell = height;
        for (int k = 0; k < cells; ++k, cell *= g) sum += cell;
        (sum > length ? high : low) = g;
    }
    return low;
}

/// What a level begins with: the last layer, and the steps from it to the points above, as the
/// layers would go on.
struct Start {
    Points front, steps;
};

/// Which points the next coarser level keeps.
struct Coarser {
    KeptPoints kept;
    Plan plan;
    std::vector<int> fronts;
};

/// One level of a cascade from coarse grids to fine ones.
class Level {
  public:
    /// @pre plan and mesh outlive this
    Level(const Plan& plan, const FrontMesh& mesh, const Sphere& sphere, const Start& start,
          int fronts)
        : plan_(plan), mesh_(mesh), sphere_(sphere), start_(start), shell_{mesh, fronts, {},
                                                                           0.0,  {},     {}} {
        points_.resize(Eigen::Index(shell_.count()), 3);
        points_.topRows(start.front.rows()) = start.front;
        set_sides();
        set_heights();
    }

    const Points& run(const FarFieldOptions& options, int iterations) {
        if (const auto next = coarser())
            follow(*next, options);
        else
            begin();
        descend(options, iterations);
        return points_;
    }

  private:
    void set_sides() {
        std::size_t on_border = 0;
        for (std::size_t p = 0; p < mesh_.size(); ++p) {
            on_border += mesh_.plane(p).isZero(0.0) ? 0 : 1;
            const auto length = [&](std::int32_t q) {
                return std::max((at(points_, std::size_t(q)) - at(points_, p)).norm(),
                                std::numeric_limits<double>::min());
            };
            for (const FrontMesh::Corner& c : mesh_.corners(p))
                shell_.sides.push_back({length(c.next), length(c.previous)});
        }
        const double cells = 0.25 * double(shell_.sides.size());
        const double area = (on_border == 0 ? 4.0 : 2.0) * M_PI;  // of a sphere of radius 1
        shell_.outer_side_mm = sphere_.radius_mm * std::sqrt(area / cells);
    }

    void set_heights() {
        const std::size_t size = mesh_.size();
        const int cells = shell_.fronts - 1;
        shell_.shares.assign(shell_.count(), 1.0);
        shell_.heights_mm.resize(shell_.count() - size);
        for (std::size_t p = 0; p < size; ++p) {
            const double length = sphere_.radius_mm - (at(points_, p) - sphere_.centre).norm();
            double height = at(start_.steps, p).norm(), way = 0.0;
            const double growth = growth_to_fill(length, height, cells);
            for (int k = 0; k < cells; ++k, height *= growth) {
                const std::size_t row = std::size_t(k) * size + p;
                shell_.heights_mm[row] = height;
                shell_.shares[row] = std::min(1.0, way / length);
                way += height;
            }
            lengths_.push_back(length);
        }
    }

    /// Straight lines to the sphere, on which points are spread.
    void begin() {
        const std::size_t size = mesh_.size();
        std::vector<Vec3> out(size), next(size);
        for (std::size_t p = 0; p < size; ++p)
            out[p] = (at(points_, p) - sphere_.centre).normalized();
        for (int round = 0; round < spreading_rounds; ++round) {
            for (std::size_t p = 0; p < size; ++p) {
                Vec3 sum = Vec3::Zero();
                for (const FrontMesh::Corner& c : mesh_.corners(p))
                    sum += out[std::size_t(c.next)] + out[std::size_t(c.previous)];
                const Vec3& plane = mesh_.plane(p);
                next[p] = (sum - plane * plane.dot(sum)).normalized();
            }
            out.swap(next);
        }
        for (std::size_t r = size; r < shell_.count(); ++r) {
            const Vec3 end = sphere_.centre + sphere_.radius_mm * out[r % size];
            const double share = shell_.shares[r];
            points_.row(Eigen::Index(r)) =
                ((1.0 - share) * at(points_, r % size) + share * end).transpose();
        }
    }

    [[nodiscard]] std::optional<Coarser> coarser() const {
        Coarser next{every_second(plan_), {}, {}};
        next.plan = subset(plan_, next.kept);
        // Blocks of few cells each hardly become coarser.
        const bool is_smaller = plan_.cell_count() > coarse_cells &&
                                3 * next.plan.cell_count() <= 2 * plan_.cell_count();
        if (!is_smaller) {
            if (shell_.fronts <= coarse_fronts) return std::nullopt;
            for (std::size_t e = 0; e < next.kept.size(); ++e) {
                next.kept[e].resize(plan_.edges[e].parameters.size());
                std::iota(next.kept[e].begin(), next.kept[e].end(), 0);
            }
            next.plan = plan_;
        }
        next.fronts = every_second(shell_.fronts - 1);
        return next;
    }

    /// Calls visit(point, coarser grid's point) for all that it keeps.
    template <class Visit>
    void for_kept(const Coarser& next, const FrontMesh& mesh, const Visit& visit) const {
        for (int b = 0; b < int(plan_.layout.blocks.size()); ++b) {
            const auto width = std::size_t(plan_.size(b)[0]);
            std::size_t number = 0;
            for (const int j : kept_along(plan_.layout, next.kept, b, 1))
                for (const int i : kept_along(plan_.layout, next.kept, b, 0))
                    visit(std::size_t(mesh_.numbers(b)[std::size_t(i) + width * std::size_t(j)]),
                          mesh.numbers(b)[number++]);
        }
    }

    /// Takes the points of a coarser grid's solution and those between them.
    void follow(const Coarser& next, const FarFieldOptions& options) {
        const FrontMesh mesh(next.plan);
        Start start{Points(Eigen::Index(mesh.size()), 3), Points(Eigen::Index(mesh.size()), 3)};
        for_kept(next, mesh, [&](std::size_t p, std::int32_t q) {
            double height = 0.0;
            for (int k = 0; k < next.fronts[1]; ++k)
                height += shell_.heights_mm[std::size_t(k) * mesh_.size() + p];
            start.front.row(q) = start_.front.row(Eigen::Index(p));
            start.steps.row(q) = height * at(start_.steps, p).normalized().transpose();
        });
        Level level(next.plan, mesh, sphere_, start, int(next.fronts.size()));
        const Points& coarse = level.run(options, most_iterations);
        for (int b = 0; b < int(plan_.layout.blocks.size()); ++b) {
            const auto at_i = between(kept_along(plan_.layout, next.kept, b, 0));
            const auto at_j = between(kept_along(plan_.layout, next.kept, b, 1));
            const auto width = std::size_t(next.plan.size(b)[0]);
            std::vector<Vec3> line(next.fronts.size());
            for (std::size_t j = 0; j < at_j.size(); ++j) {
                for (std::size_t i = 0; i < at_i.size(); ++i) {
                    const auto [m, s] = at_i[i];
                    const auto [n, t] = at_j[j];
                    const std::size_t lowest = std::size_t(m) + width * std::size_t(n);
                    for (std::size_t f = 0; f < line.size(); ++f) {
                        const auto corner = [&](std::size_t number) {
                            return at(coarse, f * mesh.size() +
                                                  std::size_t(mesh.numbers(b)[lowest + number]));
                        };
                        line[f] = (1 - t) * ((1 - s) * corner(0) + s * corner(1)) +
                                  t * ((1 - s) * corner(width) + s * corner(width + 1));
                    }
                    follow_line(std::size_t(mesh_.numbers(b)[i + at_i.size() * j]), next.fronts,
                                line);
                }
            }
        }
    }

    /// Cubics through the points of a coarser grid's line, which begin as the layers end.
    void follow_line(std::size_t p, const std::vector<int>& fronts, std::vector<Vec3>& line) {
        const std::size_t size = mesh_.size(), last = line.size() - 1;
        const Vec3 off = at(points_, p) - line[0];
        std::vector<double> ways;
        for (std::size_t f = 0; f <= last; ++f) {
            ways.push_back(shell_.shares[std::size_t(fronts[f]) * size + p]);
            line[f] += (1.0 - ways[f]) * off;
        }
        std::vector<Vec3> slopes{lengths_[p] * at(start_.steps, p).normalized()};
        for (std::size_t f = 1; f < last; ++f) {
            const double before = ways[f] - ways[f - 1], after = ways[f + 1] - ways[f];
            slopes.emplace_back((after / before * (line[f] - line[f - 1]) +
                                 before / after * (line[f + 1] - line[f])) /
                                (before + after));
        }
        slopes.emplace_back((line[last] - line[last - 1]) / (ways[last] - ways[last - 1]));
        const std::vector<Between> along = between(fronts);
        for (int k = 1; k < shell_.fronts; ++k) {
            const auto f = std::size_t(along[std::size_t(k)].first);
            const std::size_t row = std::size_t(k) * size + p;
            const double width = ways[f + 1] - ways[f];
            const double t = (shell_.shares[row] - ways[f]) / width, u = 1.0 - t;
            points_.row(Eigen::Index(row)) =
                (u * u * ((1.0 + 2.0 * t) * line[f] + t * width * slopes[f]) +
                 t * t * ((1.0 + 2.0 * u) * line[f + 1] - u * width * slopes[f + 1]))
                    .transpose();
        }
    }

    /// Newton's method with steps halved where necessary.
    void descend(const FarFieldOptions& options, int iterations) {
        const ShellEnergy energy(shell_);
        const Freedom freedom(shell_, sphere_.centre, sphere_.radius_mm);
        freedom.put_back(points_);
        ShellStep solver(shell_, energy, freedom);
        Points moved;
        double least = energy.least_determinant(points_);
        int stuck = 0;
        for (int k = 0; k < iterations && stuck < most_stuck; ++k) {
            base::report_progress(options.progress, "far field", double(k) / iterations);
            const double e = std::hypot(least_e, std::min(0.0, least));
            const double before = energy.value(points_, e);
            const Points& step = solver.solve(points_, e);
            double after = before, length = 1.0;
            for (int n = 0; n < most_halvings && !(after < before); ++n, length *= 0.5) {
                moved = points_ + length * step;
                freedom.put_back(moved);
                after = energy.value(moved, e);
            }
            if (!(after < before)) break;
            points_.swap(moved);
            const double last = least;
            least = energy.least_determinant(points_);
            const bool is_better =
                least < good_determinant && least - last > settled_determinant * std::abs(last);
            if (least > 0.0 && before - after < settled * before && !is_better) break;
            stuck = least < 0.0 && least <= share_of_progress * last ? stuck + 1 : 0;
        }
    }

    const Plan& plan_;
    const FrontMesh& mesh_;
    Sphere sphere_;
    const Start& start_;
    Shell shell_;
    std::vector<double> lengths_;  ///< from the first front to the sphere
    Points points_;
};

/// Layers end with cells of hardly any height over folds of the surface; there the next ones are no
/// lower than half of what is beside them.
Points first_steps(const FrontMesh& mesh, Points steps) {
    constexpr double least_of_neighbour = 0.5;
    Eigen::VectorXd heights = steps.rowwise().norm();
    for (bool changed = true; changed;) {
        changed = false;
        for (std::size_t p = 0; p < mesh.size(); ++p) {
            double& height = heights[Eigen::Index(p)];
            for (const FrontMesh::Corner& c : mesh.corners(p)) {
                for (const std::int32_t q : {c.next, c.previous}) {
                    if (height >= least_of_neighbour * heights[q]) continue;
                    height = least_of_neighbour * heights[q];
                    changed = true;
                }
            }
        }
    }
    for (Eigen::Index p = 0; p < steps.rows(); ++p)
        steps.row(p) *= heights[p] / steps.row(p).norm();
    return steps;
}

}  // namespace

std::vector<Points> far_fronts(const Plan& plan, const FrontMesh& mesh, const Sphere& sphere,
                               const std::array<Points, 2>& layers,
                               const FarFieldOptions& options) {
    const Eigen::VectorXd ways = (layers[1].rowwise() - sphere.centre.transpose()).rowwise().norm();
    if (!(ways.maxCoeff() < sphere.radius_mm))
        throw base::UsageError(
            fmt::format("a far field of {:g} mm around ({:g}, {:g}, {:g}) does not hold the "
                        "layers, which reach "
                        "{:g} mm; ten times that is usual",
                        sphere.radius_mm, sphere.centre.x(), sphere.centre.y(), sphere.centre.z(),
                        ways.maxCoeff()));
    const Start start{layers[1], first_steps(mesh, options.growth * (layers[1] - layers[0]))};
    std::vector<double> heights(mesh.size());
    Eigen::Map<Eigen::VectorXd>(heights.data(), Eigen::Index(heights.size())) =
        start.steps.rowwise().norm();
    const auto middle = heights.begin() + std::ptrdiff_t(heights.size() / 2);
    std::nth_element(heights.begin(), middle, heights.end());
    const double cells_of_even_height = (sphere.radius_mm - ways.mean()) / *middle;
    double cells = cells_of_even_height;
    if (options.growth > 1.0)
        cells = std::log1p(cells * (options.growth - 1.0)) / std::log(options.growth);
    cells = std::ceil(cells);
    const double count = cells * double(mesh.size());
    require_memory(count, count * point_bytes);
    const int fronts = std::max(int(cells), 2) + 1;
    Level level(plan, mesh, sphere, start, fronts);
    const Points& all = level.run(options, most_finest_iterations);
    std::vector<Points> result;
    for (Eigen::Index k = 1; k < fronts; ++k)
        result.emplace_back(all.middleRows(k * layers[1].rows(), layers[1].rows()));
    return result;
}

}  // namespace patchwright::grid
