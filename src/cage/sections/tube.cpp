#include "cage/sections/tube.h"

#include "cage/blocks/feature_chain.h"
#include "cage/sections/bend.h"
#include "geom/angle.h"
#include "geom/polyline.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace patchwright::cage {

using geom::Vec3;

namespace {

/// A line in a half plane with the sharp and smooth curves that it crosses.
struct HalfPlaneLine {
    std::vector<Vec3> points;
    std::vector<Crossing> crossed;
    LineEnd start = LineEnd::None, end = LineEnd::None;
};

// Of the way around: sharp curves that are shorter are flaws that no ring is made for.
constexpr double short_rel = 0.1;
// How much longer than its neighbour a line may be: blades and the like stand out by more.
constexpr double most_uneven = 1.3;
// Cosine between a line and the axis where it ends on that: nearer to 1 the end is a point, on
// which no cap of quads lies flat.
constexpr double steepest = 0.85;
// Share of a piece from its end over which its direction there is taken.
constexpr double end_direction_share = 0.02;
// A ring-to-ring step turns by this at most, about 30 degrees, and is within these lengths of a
// line.
constexpr double turn_rad = 0.5, longest_rel = 0.25, shortest_rel = 0.01;
// Places along a piece at which the density of rings is known, and how it is evened out: to at
// least this share of the sum of both neighbours', in as many rounds.
constexpr int cells = 200, evening_rounds = 10;
constexpr double kept_of_neighbours = 0.45;

/// In growing order.
std::vector<int> vertices_of(const SurfaceBody& body) {
    std::vector<int> vertices;
    for (const int t : body.triangles)
        for (const int v : body.mesh->triangles[std::size_t(t)]) vertices.push_back(v);
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

class TubeFinder {
  public:
    TubeFinder(const SurfaceBody& body, const geom::ModelSurface& reference,
               const TubeOptions& options, const Vec3& center, const Vec3& axis, Poll& poll)
        : body_(body), reference_(reference), options_(options), poll_(poll) {
        tube_.center = center;
        tube_.axis = axis;
    }

    std::optional<Tube> run() {
        if (!has_round_rims()) return std::nullopt;
        // Every second line is only looked at: between lines there may be more than shows on them.
        const int count = 2 * options_.around;
        for (int k = 0; k < count; ++k)
            if (!cut(2.0 * std::numbers::pi * k / count)) return std::nullopt;
        if (!find_rings() || !split() || !is_even()) return std::nullopt;
        for (int k = count - 1; k > 0; k -= 2) tube_.lines.erase(tube_.lines.begin() + k);
        for (int i = 0; i < int(tube_.lines.front().pieces.size()); ++i) place_rings(i);
        return std::move(tube_);
    }

    [[nodiscard]] const std::string& why_not() const { return why_not_; }
    [[nodiscard]] int lines_found() const { return int(lines_.size()); }

  private:
    bool refuse(std::string why) {
        why_not_ = std::move(why);
        return false;
    }

    /// The parts of a plane's lines that lie in the half plane.
    void add_parts(const SectionLoop& loop, const Vec3& outward,
                   std::vector<HalfPlaneLine>& parts) const {
        const auto& curves = reference_.features().curves;
        std::map<int, std::vector<int>> crossings;
        for (const Crossing& c : loop.crossings)
            if (curves[std::size_t(c.curve)].kind != geom::FeatureKind::Free)
                crossings[c.point].push_back(c.curve);
        const int count = int(loop.points.size());
        const auto radius = [&](int i) {
            return (loop.points[std::size_t(i % count)] - tube_.center).dot(outward);
        };
        const auto on_axis = [&](int i) {
            const double a = radius(i), b = radius(i + 1);
            return Vec3(loop.points[std::size_t(i % count)] +
                        a / (a - b) *
                            (loop.points[std::size_t((i + 1) % count)] -
                             loop.points[std::size_t(i % count)]));
        };
        int first = 0;
        if (loop.closed)
            while (first < count && radius(first) > 0.0) ++first;
        const bool whole = loop.closed && first == count;
        HalfPlaneLine part;
        bool open = false;
        const int steps = loop.closed && !whole ? count + 1 : count;
        for (int s = 0; s < steps; ++s) {
            const int i = (whole ? 0 : first) + s;
            if (radius(i) <= 0.0) {
                if (open) {
                    part.points.push_back(on_axis(i - 1));
                    part.end = LineEnd::Axis;
                    parts.push_back(std::move(part));
                }
                open = false;
                continue;
            }
            if (!open) {
                open = true;
                part = {};
                part.start = part.end = whole ? LineEnd::None : LineEnd::Free;
                if (s > 0) {
                    part.start = LineEnd::Axis;
                    part.points.push_back(on_axis(i - 1));
                }
            }
            for (const int curve : crossings[i % count])
                part.crossed.push_back({int(part.points.size()), curve});
            part.points.push_back(loop.points[std::size_t(i % count)]);
        }
        if (open) parts.push_back(std::move(part));
    }

    bool cut(double angle) {
        poll_();
        const Vec3 zero = Vec3(tube_.axis.z(), tube_.axis.x(), tube_.axis.y());  // a cyclic shift
        const Vec3 outward = std::cos(angle) * zero + std::sin(angle) * tube_.axis.cross(zero);
        const Vec3 across = tube_.axis.cross(outward);
        const Slicer slicer(body_, Spine(across));
        std::vector<HalfPlaneLine> parts;
        for (const SectionLoop& loop : slicer.cut(tube_.center.dot(across)))
            add_parts(loop, outward, parts);
        if (parts.size() != 1)
            return refuse(fmt::format("{} lines at {:.0f} degrees around it", parts.size(),
                                      angle * 180.0 / std::numbers::pi));
        if (!lines_.empty() && (lines_[0].start != parts[0].start || lines_[0].end != parts[0].end))
            return refuse("its lines end in different ways");
        lines_.push_back(std::move(parts[0]));
        tube_.lines.push_back({{}, outward});
        return true;
    }

    /// Which curves run around: sharp ones, or chains of those and of bends that need a crease,
    /// that every line crosses; of chains parts may be smooth.
    bool find_rings() {
        const auto& curves = reference_.features().curves;
        double around = 0.0, longest = 0.0;
        for (const HalfPlaneLine& line : lines_) {
            longest = std::max(longest, geom::length_of(line.points));
            for (const Vec3& p : line.points)
                around = std::max(around, 2.0 * std::numbers::pi * distance_from_axis(p));
        }
        const auto is_sharp = [&](int c) {
            return curves[std::size_t(c)].kind == geom::FeatureKind::Sharp;
        };
        const double widest = longest_rel * longest / options_.fineness;
        const auto needed = [&](int c) {
            return needs_crease(curves[std::size_t(c)], widest, options_.tolerance_mm);
        };
        std::map<int, int> crossed;
        std::set<int> counts;
        for (const HalfPlaneLine& line : lines_) {
            int count = 0;
            for (const Crossing& c : line.crossed) {
                if (!is_sharp(c.curve)) continue;
                ++crossed[c.curve];
                ++count;
            }
            counts.insert(count);
        }
        for (const auto& [curve, count] : crossed)
            if (counts.size() == 1 || count >= 2 * options_.around) rings_.insert(curve);
        std::set<int> seen;
        for (const geom::FeatureSide& f : body_.mesh->features) {
            if (!needed(f.curve) || rings_.contains(f.curve) ||
                !std::binary_search(mine_.begin(), mine_.end(), f.v0) ||
                !seen.insert(f.curve).second)
                continue;
            poll_();
            const FeatureChain chain = chain_from(f.curve, false, reference_);
            if (chain.closed &&
                std::all_of(lines_.begin(), lines_.end(), [&](const HalfPlaneLine& line) {
                    return crosses_once(line, chain.curves);
                }))
                rings_.insert(chain.curves.begin(), chain.curves.end());
            else if (is_sharp(f.curve) && curves[std::size_t(f.curve)].length >= short_rel * around)
                return refuse("a sharp line does not run around it");
        }
        return true;
    }

    static bool crosses_once(const HalfPlaneLine& line, const std::vector<int>& chain) {
        return std::count_if(line.crossed.begin(), line.crossed.end(), [&](const Crossing& c) {
                   return std::find(chain.begin(), chain.end(), c.curve) != chain.end();
               }) == 1;
    }

    [[nodiscard]] double distance_from_axis(const Vec3& p) const {
        const Vec3 d = p - tube_.center;
        return (d - d.dot(tube_.axis) * tube_.axis).norm();
    }

    bool split() {
        tube_.start = lines_[0].start;
        tube_.end = lines_[0].end;
        for (std::size_t k = 0; k < lines_.size(); ++k) {
            HalfPlaneLine& line = lines_[k];
            std::vector<int> at;
            for (const Crossing& c : line.crossed)
                if (rings_.contains(c.curve) && (at.empty() || at.back() != c.point))
                    at.push_back(c.point);
            if (line.start == LineEnd::None) close(line, at);
            tube_.sharp_start = line.start == LineEnd::None && !at.empty();
            std::vector<int> cuts{0};
            const int last = int(line.points.size()) - 1;
            for (const int i : at)
                if (i > cuts.back() && i < last) cuts.push_back(i);
            cuts.push_back(last);
            for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
                tube_.lines[k].pieces.emplace_back(line.points.begin() + cuts[i],
                                                   line.points.begin() + cuts[i + 1] + 1);
            if (tube_.lines[k].pieces.size() != tube_.lines[0].pieces.size())
                return refuse("sharp lines run around part of it only");
            for (const auto& piece : tube_.lines[k].pieces)
                if (piece.size() < 3) return refuse("sharp lines around it touch");
        }
        return is_blunt_at_axis();
    }

    /// A closed line starts and ends at its hindmost sharp point, or at its foremost point.
    void close(HalfPlaneLine& line, std::vector<int>& at) const {
        const auto along = [&](int i) { return line.points[std::size_t(i)].dot(tube_.axis); };
        int first = 0;
        if (at.empty()) {
            for (int i = 0; i < int(line.points.size()); ++i)
                if (along(i) < along(first)) first = i;
        } else {
            first = *std::max_element(at.begin(), at.end(),
                                      [&](int a, int b) { return along(a) < along(b); });
        }
        std::rotate(line.points.begin(), line.points.begin() + first, line.points.end());
        line.points.push_back(line.points.front());
        const int count = int(line.points.size()) - 1;
        for (int& i : at) i = (i - first + count) % count;
        std::sort(at.begin(), at.end());
    }

    /// Free edges with corners are no rings.
    bool has_round_rims() {
        const geom::Features& features = reference_.features();
        for (const geom::FeatureSide& f : body_.mesh->features) {
            const geom::FeatureCurve& curve = features.curves[std::size_t(f.curve)];
            if (curve.kind == geom::FeatureKind::Free && curve.start_corner >= 0 &&
                std::binary_search(mine_.begin(), mine_.end(), f.v0))
                return refuse("its free edge has corners");
        }
        return true;
    }

    /// Lines next to each other have about the same length: blades and the like stand out.
    bool is_even() {
        for (std::size_t k = 0; k < tube_.lines.size(); ++k) {
            const TubeLine& other = tube_.lines[(k + 1) % tube_.lines.size()];
            double a = 0.0, b = 0.0;
            for (int i = 0; i < int(other.pieces.size()); ++i) {
                a += tube_.lines[k].length(i);
                b += other.length(i);
            }
            if (std::max(a, b) > most_uneven * std::min(a, b))
                return refuse("lines next to each other differ in length");
        }
        return true;
    }

    bool is_blunt_at_axis() {
        for (const TubeLine& line : tube_.lines) {
            const auto& first = line.pieces.front();
            const auto& last = line.pieces.back();
            const Vec3 in = line.at(0, end_direction_share) - first.front(),
                       out = last.back() -
                             line.at(int(line.pieces.size()) - 1, 1.0 - end_direction_share);
            if ((tube_.start == LineEnd::Axis &&
                 std::abs(in.normalized().dot(tube_.axis)) > steepest) ||
                (tube_.end == LineEnd::Axis &&
                 std::abs(out.normalized().dot(tube_.axis)) > steepest))
                return refuse("it ends in a point on the axis");
        }
        return true;
    }

    /// Rings that a piece should have at each of its cells, by how its lines are bent there.
    [[nodiscard]] std::vector<double> ring_density(int piece) const {
        std::vector<double> density(cells, 0.0);
        double total = 0.0;
        for (const auto& p : tube_.lines.front().pieces) total += geom::length_of(p);
        for (const TubeLine& line : tube_.lines) {
            const double length = line.length(piece);
            for (int i = 0; i < cells; ++i) {
                const double x = (i + 0.5) / cells, h = 2.0 / cells;
                const Vec3 before = line.at(piece, x) - line.at(piece, std::max(x - h, 0.0)),
                           after = line.at(piece, std::min(x + h, 1.0)) - line.at(piece, x);
                const double turn = geom::angle_between(before, after);
                const double bend = turn / (h * length);
                const double step = std::clamp(turn_rad / std::max(bend, 1e-300),
                                               shortest_rel * total, longest_rel * total);
                density[std::size_t(i)] += length / step / cells / double(tube_.lines.size());
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

    void place_rings(int piece) {
        poll_();
        const std::vector<double> density = ring_density(piece);
        double sum = 0.0;
        for (const double d : density) sum += d;
        const int steps = std::max(1, int(std::lround(sum * options_.fineness)));
        std::vector<double> shares;
        if (piece > 0 || tube_.start != LineEnd::Axis) shares.push_back(0.0);
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
        const bool last = piece + 1 == int(tube_.lines.front().pieces.size());
        const bool on_axis =
            (piece == 0 && tube_.start == LineEnd::Axis) || (last && tube_.end == LineEnd::Axis);
        if (on_axis && steps == 1) shares.push_back(0.5);
        if (!last || tube_.end != LineEnd::Axis) shares.push_back(1.0);
        tube_.shares.push_back(std::move(shares));
    }

    const SurfaceBody& body_;
    const geom::ModelSurface& reference_;
    const TubeOptions& options_;
    Poll& poll_;
    Tube tube_;
    std::vector<HalfPlaneLine> lines_;
    std::set<int> rings_;
    std::vector<int> mine_ = vertices_of(body_);
    std::string why_not_;
};

}  // namespace

TubeSearch find_tube(const SurfaceBody& body, const geom::ModelSurface& reference,
                     const TubeOptions& options, Poll& poll) {
    const geom::SurfaceMesh& mesh = *body.mesh;
    Vec3 center = Vec3::Zero();
    double area = 0.0;
    for (const int t : body.triangles) {
        const auto& c = mesh.triangles[std::size_t(t)];
        const Vec3 p = mesh.points.row(c[0]), q = mesh.points.row(c[1]), r = mesh.points.row(c[2]);
        const double a = 0.5 * (q - p).cross(r - p).norm();
        center += a * (p + q + r) / 3.0;
        area += a;
    }
    TubeSearch result;
    if (!(area > 0.0)) return {{}, "no area"};
    center /= area;
    int most = -1;
    for (int k = 0; k < 3; ++k) {
        TubeFinder finder(body, reference, options, center, Vec3::Unit(k), poll);
        if ((result.tube = finder.run())) return result;
        if (finder.lines_found() <= most) continue;
        most = finder.lines_found();
        result.why_not = fmt::format("around {} {}", "xyz"[k], finder.why_not());
    }
    return result;
}

}  // namespace patchwright::cage
