#include "cage/sections/tube.h"

#include "cage/blocks/feature_chain.h"
#include "cage/sections/bend.h"
#include "cage/sections/ring_shares.h"
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
// Cosine between a line and the axis where it ends on that: nearer to 1 the end is a tip, on which
// no cap of quads lies flat.
constexpr double steepest = 0.85;
// Share of a piece from its end over which its direction there is taken.
constexpr double end_direction_share = 0.02;
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
        for (int i = 0; i < int(tube_.lines.front().pieces.size()); ++i) {
            poll_();
            tube_.shares.push_back(ring_shares(tube_, i, options_.fineness));
        }
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
        const double widest = longest_step_rel * longest / options_.fineness;
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
        return find_tips();
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

    /// Where lines end on the axis nearly along it, that end is a tip, in which all lines meet.
    bool find_tips() {
        const auto first = [](TubeLine& line) -> Vec3& { return line.pieces.front().front(); };
        const auto last = [](TubeLine& line) -> Vec3& { return line.pieces.back().back(); };
        const auto inward = [&](const TubeLine& line) {
            return Vec3(line.at(0, end_direction_share) - line.at(0, 0.0));
        };
        const auto outward = [&](const TubeLine& line) {
            const int piece = int(line.pieces.size()) - 1;
            return Vec3(line.at(piece, 1.0) - line.at(piece, 1.0 - end_direction_share));
        };
        return (tube_.start != LineEnd::Axis || find_tip(tube_.tips[0], first, inward)) &&
               (tube_.end != LineEnd::Axis || find_tip(tube_.tips[1], last, outward));
    }

    /// @param end        the point of a line there
    /// @param direction  of a line there, as far as end_direction_share goes
    template <class End, class Direction>
    bool find_tip(std::optional<Vec3>& tip, const End& end, const Direction& direction) {
        const auto is_steep = [&](const TubeLine& line) {
            return std::abs(direction(line).normalized().dot(tube_.axis)) > steepest;
        };
        if (std::none_of(tube_.lines.begin(), tube_.lines.end(), is_steep)) return true;
        for (const geom::FeatureCorner& corner : reference_.features().corners) {
            const auto is_near = [&](TubeLine& line) {
                return (corner.point - end(line)).norm() <= direction(line).norm();
            };
            if (!std::all_of(tube_.lines.begin(), tube_.lines.end(), is_near)) continue;
            tip = corner.point;
            for (TubeLine& line : tube_.lines) end(line) = corner.point;
            return true;
        }
        return refuse("it ends in a slender round tip on the axis");
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
