#include "grid/marcher.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::grid {

namespace {

using geom::Vec3;

/// Of the scaled Jacobian at a cell's corner. Solvers' checks want 0.02; repairs that end early
/// come within a tenth of this.
constexpr double least_jacobian = 0.025;
constexpr double tiny = 1e-300;
// Rounds in which steps are evened out as well; then they are only shortened.
constexpr int evening_repairs = 60;
constexpr int most_repairs = 300;
/// Of the scaled Jacobian that the best direction has on the surface: what its own cells do not
/// have no layer can.
constexpr double share_of_surface = 0.8;
/// A direction within 2.6 degrees of every normal beside it needs no more turning.
constexpr double sees_all = 0.999;
/// A repaired step is shorter than the one that failed, follows the mean of its neighbours, and
/// must see its faces at least so well as the best direction does (layers_test.cpp, thick layers).
constexpr double shorter_step = 0.85, shorter_best = 0.8, share_of_neighbours = 0.3;
constexpr double least_sight = 0.3;

Vec3 at(const geom::Points& points, std::size_t p) {
    return points.row(Eigen::Index(p)).transpose();
}

Vec3 unit_normal(const geom::Points& points, std::size_t p, const FrontMesh::Corner& c) {
    const Vec3 here = at(points, p);
    return (at(points, std::size_t(c.next)) - here)
        .cross(at(points, std::size_t(c.previous)) - here)
        .normalized();
}

double jacobian(const Vec3& a, const Vec3& b, const Vec3& step) {
    return a.cross(b).dot(step) / std::max(a.norm() * b.norm() * step.norm(), tiny);
}

}  // namespace

Marcher::Marcher(const FrontMesh& mesh)
    : mesh_(mesh),
      steps_(mesh.size()),
      other_(mesh.size()),
      came_(mesh.size(), Vec3::Zero()),
      normals_(mesh.corner_count()),
      best_(mesh.size()),
      limits_(mesh.size()),
      bad_(mesh.size()),
      moved_(mesh.size()),
      hopeless_(mesh.size()) {
    look_around(mesh.surface());
    for_points(mesh.size(), [&](std::size_t p) {
        const double least = least_below(mesh.surface(), p, best_[p]);
        limits_[p] = std::min(least_jacobian, share_of_surface * least);
    });
}

geom::Points Marcher::march(const geom::Points& from, const std::vector<double>& heights,
                            int smoothing, std::vector<double>& shares) {
    look_around(from);
    steps_ = best_;
    smooth_directions(smoothing);
    for_points(mesh_.size(), [&](std::size_t p) {
        // As high over the cells beside it, within limits.
        double sight = 0.0;
        for (const Vec3& n : normals(p)) sight += n.dot(steps_[p]);
        sight /= double(mesh_.corners(p).size());
        shares[p] = heights[p] / std::clamp(sight, 0.6, 1.0);
        other_[p] = steps_[p] * shares[p];
    });
    std::swap(steps_, other_);
    even_out(from, heights, smoothing);
    // Where the front itself is folded no step helps; shortening would only spread.
    for_points(mesh_.size(),
               [&](std::size_t p) { hopeless_[p] = sight(p, best_[p]) <= 0.0 ? 1 : 0; });
    repair(from, heights);
    geom::Points to(from.rows(), 3);
    for_points(mesh_.size(), [&](std::size_t p) {
        to.row(Eigen::Index(p)) = from.row(Eigen::Index(p)) + steps_[p].transpose();
    });
    for (std::size_t p = 0; p < mesh_.size(); ++p) {
        shares[p] = steps_[p].norm() / shares[p];
        came_[p] = steps_[p].normalized();
    }
    return to;
}

void Marcher::look_around(const geom::Points& front) {
    for_points(mesh_.size(), [&](std::size_t p) {
        std::size_t n = mesh_.first_corner(p);
        for (const FrontMesh::Corner& c : mesh_.corners(p))
            normals_[n++] = unit_normal(front, p, c);
        best_[p] = best_direction(front, p);
    });
}

std::span<const Vec3> Marcher::normals(std::size_t p) const {
    return {normals_.data() + mesh_.first_corner(p), mesh_.corners(p).size()};
}

Vec3 Marcher::in_plane(std::size_t p, const Vec3& v) const {
    return v - mesh_.plane(p) * mesh_.plane(p).dot(v);
}

double Marcher::sight(std::size_t p, const Vec3& direction) const {
    double least = 1.0;
    for (const Vec3& n : normals(p)) least = std::min(least, n.dot(direction));
    return least;
}

Vec3 Marcher::best_direction(const geom::Points& points, std::size_t p) const {
    const Vec3 n = searched_direction(p);
    const double seen = least_below(points, p, n);
    if (seen > 2.0 * least_jacobian || came_[p].isZero(0.0)) return n;
    return seen >= least_below(points, p, came_[p]) ? n : came_[p];
}

Vec3 Marcher::searched_direction(std::size_t p) const {
    Vec3 n = Vec3::Zero();
    for (const Vec3& m : normals(p)) n += m;
    n = in_plane(p, n).normalized();
    for (double weight = 0.5; weight > 0.005; weight *= 0.8) {
        double least = 2.0;
        Vec3 worst = n;
        for (const Vec3& m : normals(p)) {
            const double dot = m.dot(n);
            if (dot < least) {
                least = dot;
                worst = m;
            }
        }
        if (least > sees_all) break;
        n = in_plane(p, n + weight * worst).normalized();
    }
    return n;
}

Vec3 Marcher::mean_around(const std::vector<Vec3>& values, std::size_t p) const {
    Vec3 sum = Vec3::Zero();
    for (const FrontMesh::Corner& c : mesh_.corners(p)) {
        sum += values[std::size_t(c.next)] + values[std::size_t(c.previous)];
    }
    return sum / (2.0 * double(mesh_.corners(p).size()));
}

void Marcher::smooth_directions(int sweeps) {
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for_points(mesh_.size(), [&](std::size_t p) {
            const Vec3 n = in_plane(p, 0.5 * steps_[p] + 0.5 * mean_around(steps_, p)).normalized();
            // Not out of the sight of its cells.
            const double before = sight(p, steps_[p]);
            other_[p] = sight(p, n) > std::min(0.5, 0.7 * before) ? n : steps_[p];
        });
        std::swap(steps_, other_);
    }
}

void Marcher::even_out(const geom::Points& from, const std::vector<double>& heights, int sweeps) {
    for (int sweep = 0; sweep < std::min(sweeps, 4); ++sweep) {
        for_points(mesh_.size(), [&](std::size_t p) {
            const Vec3 here = at(from, p) + steps_[p];
            Vec3 mean = Vec3::Zero();
            double longest = 0.0;
            for (const FrontMesh::Corner& c : mesh_.corners(p)) {
                for (const std::int32_t q : {c.next, c.previous}) {
                    const Vec3 there = at(from, std::size_t(q)) + steps_[std::size_t(q)];
                    mean += there;
                    longest = std::max(longest, (there - here).norm());
                }
            }
            mean /= 2.0 * double(mesh_.corners(p).size());
            const double size = steps_[p].norm();
            const Vec3 n = steps_[p].normalized();  // zero beside cells without area
            Vec3 pull = in_plane(p, mean - here);
            pull -= n * n.dot(pull);
            const double weight = 0.25 * std::min(1.0, heights[p] / longest);
            // Borders keep what spreading along them leaves.
            other_[p] = steps_[p];
            if (mesh_.corners(p).size() > 2) other_[p] += weight * pull;
            if (other_[p].norm() > 2.0 * size) other_[p] = steps_[p];
        });
        std::swap(steps_, other_);
    }
}

double Marcher::least_below(const geom::Points& from, std::size_t p, const Vec3& step) const {
    double least = 1.0;
    const Vec3 here = at(from, p);
    for (const FrontMesh::Corner& c : mesh_.corners(p))
        least = std::min(least, jacobian(at(from, std::size_t(c.next)) - here,
                                         at(from, std::size_t(c.previous)) - here, step));
    return least;
}

double Marcher::least_above(const geom::Points& from, std::size_t p) const {
    double least = 1.0;
    const auto top = [&](std::size_t q) -> Vec3 { return at(from, q) + steps_[q]; };
    for (const FrontMesh::Corner& c : mesh_.corners(p))
        least = std::min(least, jacobian(top(std::size_t(c.next)) - top(p),
                                         top(std::size_t(c.previous)) - top(p), steps_[p]));
    return least;
}

bool Marcher::is_bad(const geom::Points& from, std::size_t p) const {
    return least_below(from, p, steps_[p]) <= 0.0 || least_above(from, p) <= limits_[p];
}

bool Marcher::is_near(const std::vector<char>& marks, std::size_t p) const {
    if (marks[p] != 0) return true;
    for (const FrontMesh::Corner& c : mesh_.corners(p))
        if (marks[std::size_t(c.next)] != 0 || marks[std::size_t(c.previous)] != 0) return true;
    return false;
}

void Marcher::repair(const geom::Points& from, const std::vector<double>& heights) {
    moved_.assign(mesh_.size(), 1);
    for (int round = 0; round < most_repairs; ++round) {
        for_points(mesh_.size(), [&](std::size_t p) {
            if (is_near(moved_, p)) bad_[p] = hopeless_[p] == 0 && is_bad(from, p) ? 1 : 0;
        });
        if (std::none_of(bad_.begin(), bad_.end(), [](char b) { return b != 0; })) return;
        // The neighbours that share a bad cell move less and more alike.
        for_points(mesh_.size(), [&](std::size_t p) {
            other_[p] = steps_[p];
            moved_[p] = is_near(bad_, p) ? 1 : 0;
            if (moved_[p] == 0) return;
            const Vec3& best = best_[p];
            if (round >= evening_repairs) {
                other_[p] =
                    std::max(shorter_best * steps_[p].norm(), shortest_step * heights[p]) * best;
                return;
            }
            other_[p] =
                shorter_step * in_plane(p, (1.0 - share_of_neighbours) * steps_[p] +
                                               share_of_neighbours * mean_around(steps_, p));
            const double length = other_[p].norm();
            if (length == 0.0 || sight(p, other_[p] / length) < least_sight * sight(p, best)) {
                other_[p] = shorter_step * steps_[p].norm() * best;
            }
        });
        std::swap(steps_, other_);
    }
}

}  // namespace patchwright::grid
