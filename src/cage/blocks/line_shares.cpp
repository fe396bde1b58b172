#include "cage/blocks/line_shares.h"

#include "geom/angle.h"
#include "geom/polyline.h"

#include <patchwright/base/numbers.h>

#include <algorithm>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Turn of a line, radians, at which half of its points are spread by turn instead of length.
constexpr double half_turn_rad = 1.5;

}  // namespace

std::vector<double> shares_of(const std::vector<Vec3>& points) {
    std::vector<double> length = geom::arc_lengths(points);
    for (double& l : length) l /= std::max(length.back(), 1e-300);
    return length;
}

std::vector<double> graded_shares(const std::vector<Vec3>& line, int count) {
    const std::vector<double> share = shares_of(line);
    std::vector<double> turn(line.size(), 0.0);  // before a point
    for (std::size_t i = 1; i + 1 < line.size(); ++i) {
        const Vec3 before = line[i] - line[i - 1], after = line[i + 1] - line[i];
        const double half = 0.5 * geom::angle_between(before, after);
        turn[i] += half;
        turn[i + 1] += half;
    }
    for (std::size_t i = 1; i < turn.size(); ++i) turn[i] += turn[i - 1];
    const double whole = turn.back(), by_turn = whole / (whole + half_turn_rad);
    const auto measure = [&](std::size_t i) {
        return (1.0 - by_turn) * share[i] + (whole > 0.0 ? by_turn * turn[i] / whole : 0.0);
    };
    std::vector<double> result{0.0};
    std::size_t i = 0;
    for (int k = 1; k < count; ++k) {
        const double m = double(k) / count;
        while (i + 2 < line.size() && measure(i + 1) < m) ++i;
        const double step = measure(i + 1) - measure(i);
        const double t = step > 0.0 ? (m - measure(i)) / step : 0.0;
        result.push_back(share[i] + t * (share[i + 1] - share[i]));
    }
    result.push_back(1.0);
    return result;
}

std::vector<Vec3> resampled(const std::vector<Vec3>& line, const std::vector<double>& at_shares) {
    std::vector<Vec3> result{line.front()};
    const std::vector<double> share = shares_of(line);
    std::size_t i = 0;
    for (std::size_t k = 1; k + 1 < at_shares.size(); ++k) {
        const double s = at_shares[k];
        while (i + 2 < line.size() && share[i + 1] < s) ++i;
        const double step = share[i + 1] - share[i];
        const double t = step > 0.0 ? (s - share[i]) / step : 0.0;
        result.push_back(line[i] + t * (line[i + 1] - line[i]));
    }
    result.push_back(line.back());
    return result;
}

std::vector<double> even_shares(int count) {
    std::vector<double> result;
    for (int k = 0; k <= count; ++k) result.push_back(double(k) / count);
    return result;
}

}  // namespace patchwright::cage
