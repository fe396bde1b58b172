#include "cage/sections/ring_shares.h"

#include "geom/angle.h"
#include "geom/polyline.h"

#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// A ring-to-ring step turns by this at most, about 30 degrees, and is within these lengths of a
// line.
constexpr double turn_rad = 0.5, shortest_rel = 0.01;
// Places along a piece at which the density of rings is known, and how it is evened out: to at
// least this share of the sum of both neighbours', in as many rounds.
constexpr int cells = 200, evening_rounds = 10;
constexpr double kept_of_neighbours = 0.45;

/// Rings that a piece should have at each of its cells, by how its lines are bent there.
std::vector<double> ring_density(const Tube& tube, int piece) {
    std::vector<double> density(cells, 0.0);
    double total = 0.0;
    for (const auto& p : tube.lines.front().pieces) total += geom::length_of(p);
    for (const TubeLine& line : tube.lines) {
        const double length = line.length(piece);
        for (int i = 0; i < cells; ++i) {
            const double x = (i + 0.5) / cells, h = 2.0 / cells;
            const Vec3 before = line.at(piece, x) - line.at(piece, std::max(x - h, 0.0)),
                       after = line.at(piece, std::min(x + h, 1.0)) - line.at(piece, x);
            const double turn = geom::angle_between(before, after);
            const double bend = turn / (h * length);
            const double step = std::clamp(turn_rad / std::max(bend, 1e-300), shortest_rel * total,
                                           longest_step_rel * total);
            density[std::size_t(i)] += length / step / cells / double(tube.lines.size());
        }
    }
    for (int round = 0; round < evening_rounds; ++round)
        for (int i = 0; i < cells; ++i) {
            const double a = density[std::size_t(std::max(i - 1, 0))],
                         b = density[std::size_t(std::min(i + 1, cells - 1))];
            density[std::size_t(i)] =
                std::max(density[std::size_t(i)], kept_of_neighbours * (a + b));
        }
    return density;
}

}  // namespace

std::vector<double> ring_shares(const Tube& tube, int piece, double fineness) {
    const std::vector<double> density = ring_density(tube, piece);
    double sum = 0.0;
    for (const double d : density) sum += d;
    const int steps = std::max(1, int(std::lround(sum * fineness)));
    std::vector<double> shares;
    if (piece > 0 || tube.start != LineEnd::Axis) shares.push_back(0.0);
    double reached = 0.0;
    int next = 1;
    for (int i = 0; i < cells && next < steps; ++i) {
        while (next < steps && reached + density[std::size_t(i)] >= sum * next / steps) {
            const double part = (sum * next / steps - reached) / density[std::size_t(i)];
            shares.push_back((i + part) / cells);
            ++next;
        }
        reached += density[std::size_t(i)];
    }
    const bool last = piece + 1 == int(tube.lines.front().pieces.size());
    const bool on_axis =
        (piece == 0 && tube.start == LineEnd::Axis) || (last && tube.end == LineEnd::Axis);
    if (on_axis && steps == 1) shares.push_back(0.5);
    if (!last || tube.end != LineEnd::Axis) shares.push_back(1.0);
    return shares;
}

}  // namespace patchwright::cage
