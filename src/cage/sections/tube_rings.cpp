#include "cage/sections/tube.h"
#include "geom/polyline.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace patchwright::cage {

using geom::Vec3;

namespace {

struct TubeRing {
    int piece;
    double share;
    std::optional<geom::FeatureKind> feature;  ///< on which its points lie
    double squareness = 0.0;                   ///< of rings around caps
};

// How much farther from the axis a ring around a cap is at the corners of the cap's square than on
// average, of its share: on a circle quads would have angles of more than 150 degrees there.
constexpr double squareness = 0.12;
// Half of the share of a piece between two points that tell its direction.
constexpr double ring_direction_share = 0.01;
// A body whose lines turn back by more than this share of their way along the axis has a lip.
constexpr double least_turned = 0.1;
// Steps along a piece when that is measured.
constexpr int turn_samples = 20;

std::vector<TubeRing> rings_of(const Tube& tube) {
    std::vector<TubeRing> rings;
    const int pieces = int(tube.shares.size());
    for (int i = 0; i < pieces; ++i) {
        for (const double share : tube.shares[std::size_t(i)]) {
            if (i > 0 && share == 0.0) continue;
            rings.push_back({i, share, {}});
            if (share == 1.0 && i + 1 < pieces) rings.back().feature = geom::FeatureKind::Sharp;
        }
    }
    if (tube.start == LineEnd::None) rings.pop_back();
    if (tube.sharp_start) rings.front().feature = geom::FeatureKind::Sharp;
    if (tube.start == LineEnd::Free) rings.front().feature = geom::FeatureKind::Free;
    if (tube.end == LineEnd::Free) rings.back().feature = geom::FeatureKind::Free;
    if (tube.start == LineEnd::Axis) rings.front().squareness = squareness;
    if (tube.end == LineEnd::Axis) rings.back().squareness = -squareness;
    return rings;
}

class TubeRings {
  public:
    TubeRings(const Tube& tube, const geom::ModelSurface& reference, Poll& poll)
        : tube_(tube),
          reference_(reference),
          poll_(poll),
          rings_(rings_of(tube)),
          around_(int(tube.lines.size())),
          side_(around_ / 4) {}

    Blocks run() {
        for (const TubeRing& ring : rings_)
            for (int k = 0; k < around_; ++k) blocks_.points.push_back(point(ring, k));
        const int count = int(rings_.size());
        const int strips = tube_.start == LineEnd::None ? count : count - 1;
        for (int i = 0; i < strips; ++i) {
            const int next = (i + 1) % count;
            // A strip belongs to the piece in which it ends.
            const int piece =
                next == 0 ? int(tube_.shares.size()) - 1 : rings_[std::size_t(next)].piece;
            for (int k = 0; k < around_; ++k) {
                blocks_.faces.push_back({id(i, k), id(next, k), id(next, k + 1), id(i, k + 1)});
                blocks_.groups.push_back(fmt::format("band_{}", piece + 1));
            }
        }
        for (int i = 0; i < count; ++i)
            if (rings_[std::size_t(i)].feature == geom::FeatureKind::Sharp)
                for (int k = 0; k < around_; ++k)
                    blocks_.creases.emplace_back(id(i, k), id(i, k + 1));
        if (tube_.start == LineEnd::Axis) add_end(0, false);
        if (tube_.end == LineEnd::Axis) add_end(count - 1, true);
        return std::move(blocks_);
    }

  private:
    [[nodiscard]] int id(int ring, int k) const { return ring * around_ + (k + around_) % around_; }

    /// Number of the line at the first corner of a cap's square.
    [[nodiscard]] int first_corner() const { return side_ / 2; }

    [[nodiscard]] double share_of(const TubeRing& ring, int k) const {
        const double angle = 2.0 * std::numbers::pi * (k - first_corner()) / around_;
        const double stretch = 1.0 + std::abs(ring.squareness) * std::cos(4.0 * angle);
        if (ring.squareness == 0.0) return ring.share;
        return ring.squareness > 0.0 ? ring.share * stretch : 1.0 - (1.0 - ring.share) * stretch;
    }

    /// Unit, from the surface.
    [[nodiscard]] Vec3 normal_at(const TubeRing& ring, int k) const {
        const TubeLine& line = tube_.lines[std::size_t(k)];
        const double share = share_of(ring, k), h = ring_direction_share;
        const Vec3 along = line.at(ring.piece, std::min(share + h, 1.0)) -
                           line.at(ring.piece, std::max(share - h, 0.0));
        return along.cross(tube_.axis.cross(line.outward)).normalized();
    }

    [[nodiscard]] Vec3 point(const TubeRing& ring, int k) const {
        poll_();
        const Vec3 p = tube_.lines[std::size_t(k)].at(ring.piece, share_of(ring, k));
        if (ring.feature) {
            auto feature = reference_.feature_point(p, *ring.feature);
            if (ring.feature == geom::FeatureKind::Sharp) {
                // Parts of sharp rings may be smooth.
                const auto smooth = reference_.feature_point(p, geom::FeatureKind::Smooth);
                if (smooth && (!feature || smooth->distance < feature->distance)) feature = smooth;
            }
            return feature ? feature->point : p;
        }
        return reference_.foot_point(p, normal_at(ring, k)).point;
    }

    /// A square of quads within a ring, its corners on lines; number of the point (a, b).
    struct Square {
        int side;
        std::vector<int> points;
        int& at(int a, int b) { return points[std::size_t(b * (side + 1) + a)]; }
    };

    void add_end(int ring, bool last) {
        Square square{side_, std::vector<int>(std::size_t((side_ + 1) * (side_ + 1)))};
        const int m = side_, c = first_corner();
        for (int i = 0; i < m; ++i) {
            square.at(i, 0) = id(ring, c + i);
            square.at(m, i) = id(ring, c + m + i);
            square.at(m - i, m) = id(ring, c + 2 * m + i);
            square.at(0, m - i) = id(ring, c + 3 * m + i);
        }
        if (const auto& tip = tube_.tips[last ? 1 : 0])
            add_tip(square, rings_[std::size_t(ring)], *tip);
        else
            add_cap(square, ring);
        for (int b = 0; b < m; ++b) {
            for (int a = 0; a < m; ++a) {
                std::vector<int> corners{square.at(a, b), square.at(a + 1, b),
                                         square.at(a + 1, b + 1), square.at(a, b + 1)};
                if (last) std::reverse(corners.begin(), corners.end());
                blocks_.faces.push_back(std::move(corners));
                blocks_.groups.push_back(last ? "last_cap" : "first_cap");
            }
        }
    }

    /// Inner points between those of the ring.
    void add_cap(Square& square, int ring) {
        const int m = side_;
        const auto border = [&](int k) {
            return blocks_.points[std::size_t(id(ring, first_corner() + k))];
        };
        Vec3 outward = Vec3::Zero();
        for (int k = 0; k < around_; ++k) outward += normal_at(rings_[std::size_t(ring)], k);
        outward.normalize();
        for (int b = 1; b < m; ++b) {
            for (int a = 1; a < m; ++a) {
                const double u = double(a) / m, v = double(b) / m;
                const Vec3 p = (1.0 - v) * border(a) + v * border(3 * m - a) +
                               (1.0 - u) * border(4 * m - b) + u * border(m + b) -
                               (1.0 - u) * (1.0 - v) * border(0) - u * (1.0 - v) * border(m) -
                               u * v * border(2 * m) - (1.0 - u) * v * border(3 * m);
                poll_();
                square.at(a, b) = int(blocks_.points.size());
                blocks_.points.push_back(reference_.foot_point(p, outward).point);
            }
        }
    }

    /// Smaller squares within each other, along the lines to the tip, which is a corner.
    void add_tip(Square& square, const TubeRing& ring, const Vec3& tip) {
        const int half = side_ / 2;
        for (int level = half - 1; level > 0; --level) {
            const int count = 8 * level, low = half - level, high = half + level;
            for (int k = 0; k < count; ++k) {
                // From corner to corner, as on the ring.
                const int along = k % (2 * level), turn = k / (2 * level);
                const std::array<std::array<int, 2>, 4> sides{{{low + along, low},
                                                               {high, low + along},
                                                               {high - along, high},
                                                               {low, high - along}}};
                const auto [a, b] = sides[std::size_t(turn)];
                square.at(a, b) = int(blocks_.points.size());
                blocks_.points.push_back(
                    towards_tip(ring, double(k) * around_ / count, double(level) / half));
            }
        }
        const int middle = int(blocks_.points.size());
        square.at(half, half) = middle;
        blocks_.points.push_back(tip);
        blocks_.corners.push_back(middle);
    }

    /// On the surface, between the tip (0) and the ring (1), `k` lines from the first corner.
    [[nodiscard]] Vec3 towards_tip(const TubeRing& ring, double k, double share) const {
        poll_();
        const int before = int(std::floor(k));
        Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
        for (const auto& [line, weight] :
             {std::pair{before, 1.0 - (k - before)}, {before + 1, k - before}}) {
            const int number = (first_corner() + line) % around_;
            const double on_ring = share_of(ring, number);
            const double at =
                ring.squareness > 0.0 ? share * on_ring : 1.0 - share * (1.0 - on_ring);
            point += weight * tube_.lines[std::size_t(number)].at(ring.piece, at);
            normal += weight * normal_at(ring, number);
        }
        return reference_.foot_point(point, normal.normalized()).point;
    }

    const Tube& tube_;
    const geom::ModelSurface& reference_;
    Poll& poll_;
    std::vector<TubeRing> rings_;
    int around_, side_;
    Blocks blocks_;
};

}  // namespace

double TubeLine::length(int piece) const { return geom::length_of(pieces[std::size_t(piece)]); }

Vec3 TubeLine::at(int piece, double share) const {
    return geom::point_along(pieces[std::size_t(piece)], share);
}

Blocks tube_blocks(const Tube& tube, const geom::ModelSurface& reference, Poll& poll) {
    return TubeRings(tube, reference, poll).run();
}

std::string describe(const Tube& tube) {
    const std::vector<TubeRing> rings = rings_of(tube);
    const auto sharp = std::count_if(rings.begin(), rings.end(), [](const TubeRing& r) {
        return r.feature == geom::FeatureKind::Sharp;
    });
    const auto name = [&](LineEnd end, int number) {
        if (end == LineEnd::Free) return "open";
        return tube.tips[std::size_t(number)] ? "in a tip" : "on the axis";
    };
    // Around a lip lines turn back.
    double forward = 0.0, backward = 0.0;
    for (int i = 0; i < int(tube.shares.size()); ++i) {
        for (int k = 0; k < turn_samples; ++k) {
            const double n = turn_samples;
            const double step =
                (tube.lines[0].at(i, (k + 1) / n) - tube.lines[0].at(i, k / n)).dot(tube.axis);
            (step > 0.0 ? forward : backward) += std::abs(step);
        }
    }
    const bool turns = std::min(forward, backward) > least_turned * std::max(forward, backward);
    const std::string ends =
        tube.start == LineEnd::None
            ? "closed"
            : fmt::format("ends {} and {}", name(tube.start, 0), name(tube.end, 1));
    return fmt::format("{}: {} lines x {} rings, {} of them sharp, {}",
                       turns ? "nacelle" : "body around an axis", tube.lines.size(), rings.size(),
                       sharp, ends);
}

}  // namespace patchwright::cage
