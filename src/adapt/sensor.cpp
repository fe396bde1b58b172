#include "adapt/nearest_point.h"

#include <patchwright/adapt/sensor.h>
#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>

namespace patchwright::adapt {

namespace {

/// As many as a point of a structured surface grid has around it.
constexpr std::size_t neighbour_count = 8;
/// Where points lie along one line there are none across it; the search for them ends here.
constexpr int most_looked_at = 1 << 12;

struct Neighbour {
    double distance;
    int point;
    bool operator<(const Neighbour& other) const {
        return distance != other.distance ? distance < other.distance : point < other.point;
    }
};

/// The nearest points to point `i`, not those that coincide with it, that `may_be` allows.
template <class Filter>
std::vector<Neighbour> neighbours(const geom::Bvh& tree, const geom::Points& points, int i,
                                  const Filter& may_be) {
    std::vector<Neighbour> nearest;  // a heap, the farthest first
    const geom::Vec3 p = points.row(i);
    int looked_at = 0;
    tree.nearest(p, std::numeric_limits<double>::max(), [&](int other, double bound) {
        if (++looked_at > most_looked_at) return -1.0;
        const geom::Vec3 way = points.row(other).transpose() - p;
        const double distance = way.norm();
        if (!(distance > 0.0) || !may_be(way)) return bound;
        const Neighbour found{distance, other};
        if (nearest.size() == neighbour_count) {
            if (!(found < nearest.front())) return bound;
            std::pop_heap(nearest.begin(), nearest.end());
            nearest.pop_back();
        }
        nearest.push_back(found);
        std::push_heap(nearest.begin(), nearest.end());
        return nearest.size() == neighbour_count ? nearest.front().distance : bound;
    });
    std::sort(nearest.begin(), nearest.end());
    return nearest;
}

/// What a point knows of the quantity around it.
struct Slope {
    geom::Vec3 gradient = geom::Vec3::Zero();
    double low = 0.0, high = 0.0;  ///< of the point and its neighbours
};

Slope slope_at(const geom::Bvh& tree, const geom::Points& points, const std::vector<double>& values,
               int i) {
    const geom::Vec3 p = points.row(i);
    const double value = values[std::size_t(i)];
    Slope slope{.low = value, .high = value};
    Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();  // sum of d d^T of unit vectors d
    geom::Vec3 rises = geom::Vec3::Zero();
    const auto add = [&](const std::vector<Neighbour>& found) {
        for (const Neighbour& other : found) {
            const geom::Vec3 d = (points.row(other.point).transpose() - p) / other.distance;
            const double there = values[std::size_t(other.point)];
            directions += d * d.transpose();
            rises += d * ((there - value) / other.distance);
            slope.low = std::min(slope.low, there);
            slope.high = std::max(slope.high, there);
        }
    };
    add(neighbours(tree, points, i, [](const geom::Vec3&) { return true; }));
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(directions);
    // A direction counts where as much as one neighbour lies along it.
    constexpr double one_neighbour = 1.0;
    if (axes.eigenvalues()[1] < one_neighbour) {
        const geom::Vec3 along = axes.eigenvectors().col(2);
        add(neighbours(tree, points, i, [&](const geom::Vec3& way) {
            return std::abs(way.dot(along)) < M_SQRT1_2 * way.norm();
        }));
        axes.compute(directions);
    }
    for (int k = 0; k < 3; ++k) {
        if (axes.eigenvalues()[k] < one_neighbour) continue;
        const geom::Vec3 axis = axes.eigenvectors().col(k);
        slope.gradient += axis * (axis.dot(rises) / axes.eigenvalues()[k]);
    }
    return slope;
}

}  // namespace

struct Sensor::State {
    geom::Points at;
    std::vector<double> values;
    geom::Bvh tree;
    double range = 0.0;

    /// Of points that have been asked for. Grids ask for few of a large solution's.
    enum class Known : std::uint8_t { No, BeingWritten, Yes };
    mutable std::vector<Slope> slopes;
    mutable std::vector<std::atomic<Known>> known;

    [[nodiscard]] Slope slope(int i) const {
        const auto n = std::size_t(i);
        if (known[n].load(std::memory_order_acquire) == Known::Yes) return slopes[n];
        const Slope made = slope_at(tree, at, values, i);
        Known none = Known::No;
        if (known[n].compare_exchange_strong(none, Known::BeingWritten)) {
            slopes[n] = made;
            known[n].store(Known::Yes, std::memory_order_release);
        }
        return made;
    }
};

Sensor::Sensor(geom::Points at, std::vector<double> values) {
    if (values.empty() || at.rows() != static_cast<Eigen::Index>(values.size()))
        throw base::InvalidArgument(
            fmt::format("{} points with {} values", at.rows(), values.size()));
    for (std::size_t i = 0; i < values.size(); ++i)
        if (!std::isfinite(values[i]))
            throw base::InvalidArgument(
                fmt::format("value {} is {}; it must be finite", i + 1, values[i]));
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    const double range = *high - *low;
    const std::size_t count = values.size();
    geom::Bvh tree = tree_of_points(at);
    state_ = std::make_shared<State>(State{std::move(at), std::move(values), std::move(tree), range,
                                           std::vector<Slope>(count),
                                           std::vector<std::atomic<State::Known>>(count)});
}

double Sensor::operator()(const geom::Vec3& p) const {
    const int i = nearest_point(state_->tree, state_->at, p);
    const Slope slope = state_->slope(i);
    const geom::Vec3 way = p - state_->at.row(i).transpose();
    return std::clamp(state_->values[std::size_t(i)] + slope.gradient.dot(way), slope.low,
                      slope.high);
}

double Sensor::range() const { return state_->range; }

}  // namespace patchwright::adapt
