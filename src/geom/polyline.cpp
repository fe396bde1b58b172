#include "geom/polyline.h"

#include <patchwright/geom/nearest.h>

#include <algorithm>
#include <limits>

namespace patchwright::geom {

double length_of(const Polyline& line) {
    double length = 0.0;
    for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
    return length;
}

std::vector<double> arc_lengths(const Polyline& line) {
    std::vector<double> lengths{0.0};
    for (std::size_t i = 1; i < line.size(); ++i)
        lengths.push_back(lengths.back() + (line[i] - line[i - 1]).norm());
    return lengths;
}

std::vector<double> arc_length_shares(const Polyline& line) {
    std::vector<double> lengths = arc_lengths(line);
    for (double& l : lengths) l /= std::max(lengths.back(), 1e-300);
    return lengths;
}

Vec3 point_along(const Polyline& line, double share) {
    double left = share * length_of(line);
    for (std::size_t i = 1; i < line.size(); ++i) {
        const double step = (line[i] - line[i - 1]).norm();
        if (left <= step && step > 0.0) return line[i - 1] + left / step * (line[i] - line[i - 1]);
        left -= step;
    }
    return line.back();
}

Polyline part_of(const Polyline& line, double from, double to) {
    const double whole = length_of(line);
    Polyline part;
    double passed = 0.0;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Vec3 along = line[i] - line[i - 1];
        const double step = along.norm();
        const double first = std::clamp((from * whole - passed) / step, 0.0, 1.0);
        const double last = std::clamp((to * whole - passed) / step, 0.0, 1.0);
        passed += step;
        if (!(step > 0.0) || !(last > first)) continue;
        if (part.empty()) part.emplace_back(line[i - 1] + first * along);
        part.emplace_back(line[i - 1] + last * along);
    }
    return part.empty() ? Polyline{line.front(), line.back()} : part;
}

Polyline thinned(const Polyline& line) {
    constexpr std::size_t most = 128;
    if (line.size() <= most) return line;
    Polyline result;
    for (std::size_t i = 0; i < most; ++i) {
        result.push_back(line[i * (line.size() - 1) / (most - 1)]);
    }
    return result;
}

double distance_to(const Polyline& line, const Vec3& q) {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < line.size(); ++i)
        best = std::min(best, (nearest_on_segment(q, line[i - 1], line[i]).point - q).norm());
    return best;
}

}  // namespace patchwright::geom
