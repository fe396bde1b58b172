#include "grid/smooth_cells.h"

#include <patchwright/base/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace patchwright::grid {

using geom::Vec3;

namespace {

constexpr std::size_t cells_a_task = 2048;
/// Weight of sizes beside that of shapes.
constexpr double size_weight = 0.3;
/// Sweeps in which wanted lengths become alike along the strips of cells that they lie across.
constexpr int length_sweeps = 30;
/// Of the longest line: lines that are shorter, as where points coincide, count as so long.
constexpr double least_length_rel = 1e-6;
/// Area over that wanted, below which a corner counts as folded, and has a bounded energy.
constexpr double least_area = 1e-2;
/// Radians; where two cells alone meet, their sides cannot turn by more.
constexpr double widest_angle = 2.6;

Vec3 at(const geom::Points& points, std::int32_t p) { return points.row(p).transpose(); }

/// A corner's sides against those wanted. With T the matrix that takes these to those: |T|^2 and
/// the determinant, kept above zero.
struct Shape {
    double a, b;           ///< over the lengths wanted
    double c11, c12, c22;  ///< |T|^2 as a form of both sides
    double stretch;
    double unit, area, root, h;

    Shape(const Vec3& next, const Vec3& previous, const Vec3& normal, const WantedCorner& w,
          bool folded)
        : a(1.0 / w.next_mm), b(1.0 / w.previous_mm) {
        const double by_sine2 = 1.0 / (w.sine * w.sine);
        c11 = a * a * by_sine2;
        c12 = -w.cosine * a * b * by_sine2;
        c22 = b * b * by_sine2;
        stretch = c11 * next.squaredNorm() + 2.0 * c12 * next.dot(previous) +
                  c22 * previous.squaredNorm();
        unit = a * b / w.sine;
        area = unit * normal.dot(next.cross(previous));
        root = folded ? std::sqrt(area * area + 4.0 * least_area * least_area) : area;
        h = 0.5 * (area + root);
    }
    [[nodiscard]] double energy() const {
        if (!(h > 0.0)) return std::numeric_limits<double>::infinity();
        const double d = difference();
        return d + d * d;  // the worst ones count more
    }
    [[nodiscard]] double difference() const {
        return 0.5 * stretch / h - 1.0 + size_weight * (0.5 * (h + 1.0 / h) - 1.0);
    }
};

/// The number of a line between two points.
class Lines {
  public:
    explicit Lines(const std::vector<SmoothCells::Cell>& cells) {
        keys_.reserve(4 * cells.size());
        for (const auto& cell : cells)
            for (std::size_t k = 0; k < 4; ++k)
                keys_.push_back(key(cell.points[k], cell.points[(k + 1) % 4]));
        std::sort(keys_.begin(), keys_.end());
        keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
    }
    [[nodiscard]] std::size_t size() const { return keys_.size(); }
    [[nodiscard]] std::size_t number(std::int32_t p, std::int32_t q) const {
        return std::size_t(std::lower_bound(keys_.begin(), keys_.end(), key(p, q)) - keys_.begin());
    }
    [[nodiscard]] std::pair<std::int32_t, std::int32_t> ends(std::size_t line) const {
        return {std::int32_t(keys_[line] >> 32), std::int32_t(keys_[line] & 0xffffffffU)};
    }

  private:
    static std::uint64_t key(std::int32_t p, std::int32_t q) {
        const auto [low, high] = std::minmax(p, q);
        return std::uint64_t(low) << 32 | std::uint64_t(std::uint32_t(high));
    }
    std::vector<std::uint64_t> keys_;
};

}  // namespace

SmoothCells::SmoothCells(const Plan& plan, const FrontMesh& mesh,
                         const std::function<bool(std::int32_t, std::int32_t)>& is_feature)
    : point_count_(mesh.size()) {
    collect(plan, mesh);
    part_normals(is_feature);
    want_lengths(mesh.surface());
    want_angles(mesh.surface());
}

void SmoothCells::collect(const Plan& plan, const FrontMesh& mesh) {
    for (const auto& points : mesh.cells(plan)) cells_.push_back({points, {}, {}});
    begin_.assign(point_count_ + 1, 0);
    for (const Cell& cell : cells_)
        for (const std::int32_t p : cell.points) ++begin_[std::size_t(p) + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    corners_.resize(begin_.back());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t c = 0; c < cells_.size(); ++c)
        for (std::size_t k = 0; k < 4; ++k)
            corners_[next[std::size_t(cells_[c].points[k])]++] = std::int32_t(4 * c + k);
}

/// Corners at one point belong together where they share a line that is no feature.
void SmoothCells::part_normals(const std::function<bool(std::int32_t, std::int32_t)>& is_feature) {
    std::int32_t count = 0;
    for (std::size_t p = 0; p < point_count_; ++p) {
        std::vector<std::int32_t> left(corners_.begin() + std::ptrdiff_t(begin_[p]),
                                       corners_.begin() + std::ptrdiff_t(begin_[p + 1]));
        while (!left.empty()) {
            std::vector<std::int32_t> open{left.back()};
            left.pop_back();
            while (!open.empty()) {
                const std::int32_t corner = open.back();
                open.pop_back();
                Cell& cell = cells_[std::size_t(corner) / 4];
                const std::size_t k = std::size_t(corner) % 4;
                cell.normals[k] = count;
                for (const std::int32_t q : {cell.points[(k + 1) % 4], cell.points[(k + 3) % 4]}) {
                    if (is_feature(std::int32_t(p), q)) continue;
                    const auto shares = [&](std::int32_t other) {
                        const Cell& there = cells_[std::size_t(other) / 4];
                        const std::size_t m = std::size_t(other) % 4;
                        return there.points[(m + 1) % 4] == q || there.points[(m + 3) % 4] == q;
                    };
                    const auto rest =
                        std::stable_partition(left.begin(), left.end(),
                                              [&](std::int32_t other) { return !shares(other); });
                    open.insert(open.end(), rest, left.end());
                    left.erase(rest, left.end());
                }
            }
            ++count;
        }
    }
    normals_.resize(std::size_t(count));
}

void SmoothCells::want_lengths(const geom::Points& points) {
    const Lines lines(cells_);
    std::vector<double> length(lines.size());
    for (std::size_t line = 0; line < lines.size(); ++line) {
        const auto [p, q] = lines.ends(line);
        length[line] = (at(points, p) - at(points, q)).norm();
    }
    const double least = least_length_rel * *std::max_element(length.begin(), length.end());
    for (double& l : length) l = std::log(std::max(l, least));
    // Per line those opposite to it, at most two.
    std::vector<std::array<std::int32_t, 2>> opposite(lines.size(), {-1, -1});
    std::vector<std::array<std::int32_t, 4>> of_cell(cells_.size());
    for (std::size_t c = 0; c < cells_.size(); ++c) {
        for (std::size_t k = 0; k < 4; ++k)
            of_cell[c][k] =
                std::int32_t(lines.number(cells_[c].points[k], cells_[c].points[(k + 1) % 4]));
        for (std::size_t k = 0; k < 4; ++k) {
            auto& known = opposite[std::size_t(of_cell[c][k])];
            known[known[0] < 0 ? 0 : 1] = of_cell[c][(k + 2) % 4];
        }
    }
    std::vector<double> next(length.size());
    for (int sweep = 0; sweep < length_sweeps; ++sweep) {
        for (std::size_t line = 0; line < length.size(); ++line) {
            double sum = 0.0;
            int count = 0;
            for (const std::int32_t other : opposite[line]) {
                if (other < 0) continue;
                sum += length[std::size_t(other)];
                ++count;
            }
            next[line] = 0.5 * length[line] + 0.5 * sum / count;
        }
        length.swap(next);
    }
    for (std::size_t c = 0; c < cells_.size(); ++c) {
        for (std::size_t k = 0; k < 4; ++k) {
            cells_[c].wanted[k].next_mm = std::exp(length[std::size_t(of_cell[c][k])]);
            cells_[c].wanted[k].previous_mm =
                std::exp(length[std::size_t(of_cell[c][(k + 3) % 4])]);
        }
    }
}

bool SmoothCells::is_inside(std::size_t p) const {
    std::vector<std::int32_t> after, before;
    for (std::size_t n = begin_[p]; n < begin_[p + 1]; ++n) {
        const Cell& cell = cells_[std::size_t(corners_[n]) / 4];
        const std::size_t k = std::size_t(corners_[n]) % 4;
        after.push_back(cell.points[(k + 1) % 4]);
        before.push_back(cell.points[(k + 3) % 4]);
    }
    std::sort(after.begin(), after.end());
    std::sort(before.begin(), before.end());
    return after == before;
}

/// Beside features as much as there is, shared evenly.
void SmoothCells::want_angles(const geom::Points& points) {
    std::vector<double> sum(normals_.size(), 0.0);
    std::vector<int> count(normals_.size(), 0);
    const auto for_corners = [&](const auto& visit) {
        for (Cell& cell : cells_)
            for (std::size_t k = 0; k < 4; ++k) visit(cell, k);
    };
    for_corners([&](Cell& cell, std::size_t k) {
        const Vec3 here = at(points, cell.points[k]);
        const Vec3 a = at(points, cell.points[(k + 1) % 4]) - here;
        const Vec3 b = at(points, cell.points[(k + 3) % 4]) - here;
        const auto n = std::size_t(cell.normals[k]);
        sum[n] += std::atan2(a.cross(b).norm(), a.dot(b));
        ++count[n];
    });
    // Without features the full angle, whatever the cells fold to.
    for (std::size_t p = 0; p < point_count_; ++p) {
        const std::int32_t first = corners_[begin_[p]];
        const auto n = std::size_t(cells_[std::size_t(first) / 4].normals[std::size_t(first) % 4]);
        if (std::size_t(count[n]) == begin_[p + 1] - begin_[p] && is_inside(p))
            sum[n] = 2.0 * std::numbers::pi;
    }
    for_corners([&](Cell& cell, std::size_t k) {
        const auto n = std::size_t(cell.normals[k]);
        const double angle = std::min(sum[n] / count[n], widest_angle);
        cell.wanted[k].cosine = std::cos(angle);
        cell.wanted[k].sine = std::sin(angle);
    });
}

void SmoothCells::measure_normals(const geom::Points& points) {
    std::fill(normals_.begin(), normals_.end(), Vec3::Zero());
    for (const Cell& cell : cells_) {
        for (std::size_t k = 0; k < 4; ++k) {
            const Vec3 here = at(points, cell.points[k]);
            const Vec3 a = at(points, cell.points[(k + 1) % 4]) - here;
            const Vec3 b = at(points, cell.points[(k + 3) % 4]) - here;
            const WantedCorner& w = cell.wanted[k];
            normals_[std::size_t(cell.normals[k])] += a.cross(b) / (w.next_mm * w.previous_mm);
        }
    }
    for (Vec3& n : normals_) n.normalize();
    for (Cell& cell : cells_) {
        for (std::size_t k = 0; k < 4; ++k) {
            const Vec3 here = at(points, cell.points[k]);
            const Shape shape(at(points, cell.points[(k + 1) % 4]) - here,
                              at(points, cell.points[(k + 3) % 4]) - here,
                              normals_[std::size_t(cell.normals[k])], cell.wanted[k], true);
            cell.folded[k] = shape.area <= least_area;
        }
    }
}

geom::Points SmoothCells::point_normals() const {
    geom::Points result(Eigen::Index(point_count_), 3);
    for (std::size_t p = 0; p < point_count_; ++p) {
        const std::int32_t first = corners_[begin_[p]];
        const Cell& cell = cells_[std::size_t(first) / 4];
        result.row(Eigen::Index(p)) =
            normals_[std::size_t(cell.normals[std::size_t(first) % 4])].transpose();
    }
    return result;
}

void SmoothCells::energies(const geom::Points& points, std::vector<double>& result) const {
    result.resize(cells_.size());
    base::parallel_for(cells_.size(), cells_a_task, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = first; c < last; ++c) {
            const Cell& cell = cells_[c];
            double sum = 0.0;
            for (std::size_t k = 0; k < 4; ++k) {
                const Vec3 here = at(points, cell.points[k]);
                sum += Shape(at(points, cell.points[(k + 1) % 4]) - here,
                             at(points, cell.points[(k + 3) % 4]) - here,
                             normals_[std::size_t(cell.normals[k])], cell.wanted[k], cell.folded[k])
                           .energy();
            }
            result[c] = sum;
        }
    });
}

SmoothCells::Derivatives SmoothCells::derivatives(std::size_t number, const geom::Points& points,
                                                  const std::vector<Basis>& bases) const {
    using Vector8 = Eigen::Matrix<double, 8, 1>;
    using Matrix38 = Eigen::Matrix<double, 3, 8>;
    const Cell& cell = cells_[number];
    Derivatives result{Vector8::Zero(), Eigen::Matrix<double, 8, 8>::Zero()};
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t n = (k + 1) % 4, m = (k + 3) % 4;
        const Vec3 here = at(points, cell.points[k]);
        const Vec3 next = at(points, cell.points[n]) - here;
        const Vec3 previous = at(points, cell.points[m]) - here;
        const Vec3& normal = normals_[std::size_t(cell.normals[k])];
        const Shape shape(next, previous, normal, cell.wanted[k], cell.folded[k]);
        Matrix38 d_next = Matrix38::Zero(), d_previous = Matrix38::Zero();
        const Basis& own = bases[std::size_t(cell.points[k])];
        d_next.middleCols<2>(Eigen::Index(2 * k)) = -own;
        d_next.middleCols<2>(Eigen::Index(2 * n)) = bases[std::size_t(cell.points[n])];
        d_previous.middleCols<2>(Eigen::Index(2 * k)) = -own;
        d_previous.middleCols<2>(Eigen::Index(2 * m)) = bases[std::size_t(cell.points[m])];
        // Half of |T|^2, and h.
        const Vector8 d_stretch =
            d_next.transpose() * (shape.c11 * next + shape.c12 * previous) +
            d_previous.transpose() * (shape.c12 * next + shape.c22 * previous);
        const double slope_of_h = 0.5 * (1.0 + shape.area / shape.root) * shape.unit;
        const Vector8 d_h = slope_of_h * (d_next.transpose() * previous.cross(normal) +
                                          d_previous.transpose() * normal.cross(next));
        const double h = shape.h, square = h * h;
        const Vector8 first =
            d_stretch / h +
            (-0.5 * shape.stretch / square + 0.5 * size_weight * (1.0 - 1.0 / square)) * d_h;
        const double slope_of_energy = 1.0 + 2.0 * shape.difference();
        result.first += slope_of_energy * first;
        const Matrix38 with_next = (shape.c11 * d_next + shape.c12 * d_previous) / h;
        const Matrix38 with_previous = (shape.c12 * d_next + shape.c22 * d_previous) / h;
        const Vector8 mixed =
            (0.5 * (shape.stretch + size_weight) / (h * square)) * d_h - d_stretch / square;
        result.second += slope_of_energy * (d_next.transpose() * with_next +
                                            d_previous.transpose() * with_previous +
                                            mixed * d_h.transpose() + d_h * mixed.transpose()) +
                         2.0 * first * first.transpose();
    }
    return result;
}

}  // namespace patchwright::grid
