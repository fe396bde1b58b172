#include "measure/corner_fans.h"

#include <patchwright/base/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace patchwright::measure {

using geom::Vec3;

// The surfaces around a corner, each up to the same parameter, make up a disc. Seen along a
// direction, a point has as many images as the border of the disc winds around it, if the surfaces
// nowhere turn over (their Jacobians are positive, so that each image counts one). A border whose
// angle around the corner only grows, by 2 pi, winds once at most: the disc has no two points one
// behind the other. Signs are those of Bernstein coefficients.

namespace {

constexpr double shared_side_rel = 1e-9;  // of the diagonal: control points of shared sides
constexpr int most_quarterings = 5;       // of a piece, for its Jacobian
constexpr std::size_t fewest_sectors = 3;

using Net = Eigen::Matrix<double, 16, 3, Eigen::RowMajor>;
using Plane = Eigen::Matrix<double, 2, 3>;
using FlatNet = Eigen::Matrix<double, 16, 2, Eigen::RowMajor>;

double cross(const Eigen::RowVector2d& a, const Eigen::RowVector2d& b) {
    return a[0] * b[1] - a[1] * b[0];
}

/// A surface seen from one of its corners: a and b run away from it, a to b counter-clockwise.
class Sector {
  public:
    Sector(const SurfacePieces& pieces, int surface, int corner)
        : pieces_(&pieces), surface_(surface), corner_(corner) {}

    [[nodiscard]] int surface() const { return surface_; }
    [[nodiscard]] int corner() const { return corner_; }

    [[nodiscard]] int count_a() const {
        return corner_ % 2 == 0 ? pieces_->spans_u() : pieces_->spans_v();
    }
    [[nodiscard]] int count_b() const {
        return corner_ % 2 == 0 ? pieces_->spans_v() : pieces_->spans_u();
    }

    [[nodiscard]] int span(int p, int q) const {
        const int last_u = pieces_->spans_u() - 1, last_v = pieces_->spans_v() - 1;
        const std::array<std::array<int, 2>, 4> places{
            {{p, q}, {last_u - q, p}, {last_u - p, last_v - q}, {q, last_v - p}}};
        const auto [i, j] = places[std::size_t(corner_)];
        return i * pieces_->spans_v() + j;
    }

    [[nodiscard]] Net net(int p, int q) const {
        const Net& given = pieces_->piece(span(p, q)).net;
        Net result;
        for (int r = 0; r < 4; ++r) {
            for (int c = 0; c < 4; ++c) {
                const std::array<int, 4> from{4 * r + c, 4 * (3 - c) + r, 4 * (3 - r) + 3 - c,
                                              4 * c + 3 - r};
                result.row(4 * r + c) = given.row(from[std::size_t(corner_)]);
            }
        }
        return result;
    }

    /// Widths of spans from the corner on, summed up.
    [[nodiscard]] std::vector<double> reach(bool along_a) const {
        std::vector<double> sums;
        double sum = 0.0;
        for (int k = 0; k < (along_a ? count_a() : count_b()); ++k) {
            const BezierPiece& piece = pieces_->piece(along_a ? span(k, 0) : span(0, k));
            const auto& range = along_a == (corner_ % 2 == 0) ? piece.u : piece.v;
            sums.push_back(sum += range[1] - range[0]);
        }
        return sums;
    }

  private:
    const SurfacePieces* pieces_;
    int surface_, corner_;
};

/// So many spans from the corner of a sector.
struct Region {
    int a = 0, b = 0;
};

std::optional<int> spans_within(const std::vector<double>& reach, double width) {
    constexpr double same_width = 1e-12;
    for (std::size_t k = 0; k < reach.size(); ++k)
        if (std::abs(reach[k] - width) <= same_width * width) return int(k) + 1;
    return std::nullopt;
}

using JacobianSums = Eigen::Matrix<double, 6, 6>;

/// Coefficients of degree 5 by 5 of (a derivative) x (b derivative), up to positive factors.
JacobianSums jacobian_of(const FlatNet& net) {
    constexpr std::array<double, 3> two{1, 2, 1};
    constexpr std::array<double, 4> three{1, 3, 3, 1};
    JacobianSums sums = JacobianSums::Zero();
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) {
            const Eigen::RowVector2d da = two[std::size_t(i)] * three[std::size_t(j)] *
                                          (net.row(4 * i + 4 + j) - net.row(4 * i + j));
            for (int k = 0; k < 4; ++k) {
                for (int l = 0; l < 3; ++l) {
                    sums(i + k, j + l) += three[std::size_t(k)] * two[std::size_t(l)] *
                                          cross(da, net.row(4 * k + l + 1) - net.row(4 * k + l));
                }
            }
        }
    }
    return sums;
}

/// A quarter of a piece, at high a and high b or not.
FlatNet quarter(const FlatNet& net, bool high_a, bool high_b) {
    Eigen::Matrix4d low, high;  // de Casteljau in the middle
    low << 8, 0, 0, 0, 4, 4, 0, 0, 2, 4, 2, 0, 1, 3, 3, 1;
    low /= 8.0;
    high = low.reverse();
    FlatNet result;
    for (int x = 0; x < 2; ++x) {
        Eigen::Matrix4d values;
        for (int k = 0; k < 16; ++k) values(k / 4, k % 4) = net(k, x);
        values = (high_a ? high : low) * values * (high_b ? high : low).transpose();
        for (int k = 0; k < 16; ++k) result(k, x) = values(k / 4, k % 4);
    }
    return result;
}

/// Whether the Jacobian is positive, told by coefficients of the piece or of its quarters.
bool is_upright(const FlatNet& net, int quarterings) {
    const JacobianSums sums = jacobian_of(net);
    if ((sums.array() > 0.0).all()) return true;
    const bool is_positive_at_corners =
        sums(0, 0) > 0.0 && sums(0, 5) > 0.0 && sums(5, 0) > 0.0 && sums(5, 5) > 0.0;
    if (quarterings == 0 || !is_positive_at_corners) return false;
    for (const bool high_a : {false, true})
        for (const bool high_b : {false, true})
            if (!is_upright(quarter(net, high_a, high_b), quarterings - 1)) return false;
    return true;
}

/// Whether the angle around the origin grows along a cubic.
bool turns_forward(const Eigen::Matrix<double, 4, 2>& curve) {
    constexpr std::array<double, 3> two{1, 2, 1};
    constexpr std::array<double, 4> three{1, 3, 3, 1};
    std::array<double, 6> sums{};
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 3; ++j)
            sums[std::size_t(i + j)] += three[std::size_t(i)] * two[std::size_t(j)] *
                                        cross(curve.row(i), curve.row(j + 1) - curve.row(j));
    return std::all_of(sums.begin(), sums.end(), [](double sum) { return sum > 0.0; });
}

class Fan {
  public:
    explicit Fan(std::vector<Sector> sectors) : sectors_(std::move(sectors)) {
        apex_ = sectors_.front().net(0, 0).row(0).transpose();
        Vec3 normal = Vec3::Zero();
        for (const Sector& sector : sectors_) {
            const Net net = sector.net(0, 0);
            const Vec3 a = (net.row(4) - net.row(0)).transpose();
            const Vec3 b = (net.row(1) - net.row(0)).transpose();
            normal += a.cross(b).stableNormalized();
        }
        normal.stableNormalize();
        plane_.row(0) = normal.unitOrthogonal();
        plane_.row(1) = normal.cross(plane_.row(0).transpose());
    }

    /// The largest regions that are seen once; empty when there are none.
    [[nodiscard]] std::vector<Region> regions(double same) {
        if (!is_closed(same)) return {};
        const std::vector<double> widths = sectors_.front().reach(true);
        for (auto width = widths.rbegin(); width != widths.rend(); ++width) {
            std::vector<Region> regions = within(*width);
            if (!regions.empty() && are_joined(regions, same) && winds_once(regions) &&
                are_upright(regions))
                return regions;
        }
        return {};
    }
    [[nodiscard]] const std::vector<Sector>& sectors() const { return sectors_; }

  private:
    [[nodiscard]] FlatNet flat(const Net& net) const {
        return (net.rowwise() - apex_.transpose()) * plane_.transpose();
    }

    /// Puts the sectors in order; each begins where the one before ends.
    bool is_closed(double same) {
        const auto angle = [&](const Sector& sector) {
            const Eigen::Vector2d way = plane_ * (sector.net(0, 0).row(4).transpose() - apex_);
            return std::atan2(way[1], way[0]);
        };
        std::vector<std::pair<double, std::size_t>> order;
        for (std::size_t k = 0; k < sectors_.size(); ++k) order.emplace_back(angle(sectors_[k]), k);
        std::sort(order.begin(), order.end());
        std::vector<Sector> sorted;
        for (const auto& entry : order) sorted.push_back(sectors_[entry.second]);
        sectors_.swap(sorted);
        for (std::size_t k = 0; k < sectors_.size(); ++k) {
            const Net here = sectors_[k].net(0, 0);
            const Net next = sectors_[(k + 1) % sectors_.size()].net(0, 0);
            if ((here.row(1) - next.row(4)).norm() > same) return false;
        }
        return true;
    }

    [[nodiscard]] std::vector<Region> within(double width) const {
        std::vector<Region> regions;
        for (const Sector& sector : sectors_) {
            const auto a = spans_within(sector.reach(true), width);
            const auto b = spans_within(sector.reach(false), width);
            if (!a || !b) return {};
            regions.push_back({*a, *b});
        }
        return regions;
    }

    /// Whether neighbours have the same curve between them.
    [[nodiscard]] bool are_joined(const std::vector<Region>& regions, double same) const {
        for (std::size_t k = 0; k < sectors_.size(); ++k) {
            const std::size_t after = (k + 1) % sectors_.size();
            if (regions[k].b != regions[after].a) return false;
            for (int q = 0; q < regions[k].b; ++q) {
                const Net here = sectors_[k].net(0, q), next = sectors_[after].net(q, 0);
                for (int c = 0; c < 4; ++c)
                    if ((here.row(c) - next.row(4 * c)).norm() > same) return false;
            }
        }
        return true;
    }

    [[nodiscard]] bool winds_once(const std::vector<Region>& regions) const {
        double turned = 0.0;
        const auto turns = [&](const Eigen::Matrix<double, 4, 2>& curve) {
            const Eigen::RowVector2d from = curve.row(0), to = curve.row(3);
            turned += std::atan2(cross(from, to), from.dot(to));
            return turns_forward(curve);
        };
        for (std::size_t k = 0; k < sectors_.size(); ++k) {
            const auto [a, b] = regions[k];
            for (int q = 0; q < b; ++q)
                if (!turns(flat(sectors_[k].net(a - 1, q)).bottomRows<4>())) return false;
            for (int p = 0; p < a; ++p) {
                const FlatNet net = flat(sectors_[k].net(p, b - 1));
                Eigen::Matrix<double, 4, 2> curve;
                for (int r = 0; r < 4; ++r) curve.row(r) = net.row(4 * (3 - r) + 3);
                if (!turns(curve)) return false;
            }
        }
        return turned < 3.0 * M_PI;  // a whole number of turns
    }

    [[nodiscard]] bool are_upright(const std::vector<Region>& regions) const {
        for (std::size_t k = 0; k < sectors_.size(); ++k)
            for (int p = 0; p < regions[k].a; ++p)
                for (int q = 0; q < regions[k].b; ++q)
                    if (!is_upright(flat(sectors_[k].net(p, q)), most_quarterings)) return false;
        return true;
    }

    std::vector<Sector> sectors_;
    Vec3 apex_;
    Plane plane_;
};

/// Sectors at the same place.
std::vector<Fan> fans_of(const std::vector<std::unique_ptr<SurfacePieces>>& surfaces) {
    std::map<std::array<double, 3>, std::vector<Sector>> at;
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        for (int corner = 0; corner < 4; ++corner) {
            const Sector sector(*surfaces[s], int(s), corner);
            const Eigen::RowVector3d place = sector.net(0, 0).row(0);
            at[{place[0], place[1], place[2]}].push_back(sector);
        }
    }
    std::vector<Fan> fans;
    for (auto& [place, sectors] : at)
        if (sectors.size() >= fewest_sectors) fans.emplace_back(std::move(sectors));
    return fans;
}

}  // namespace

CornerFans::CornerFans(const std::vector<std::unique_ptr<SurfacePieces>>& surfaces) {
    geom::Box3 box;
    for (const auto& surface : surfaces) {
        fans_.emplace_back(std::size_t(surface->span_count()), Fans{-1, -1, -1, -1});
        for (int k = 0; k < surface->span_count(); ++k) box.add(surface->piece(k).box);
    }
    const double same = shared_side_rel * box.diagonal();
    std::vector<Fan> fans = fans_of(surfaces);
    std::vector<std::vector<Region>> regions(fans.size());
    base::parallel_for(fans.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) regions[k] = fans[k].regions(same);
    });
    for (std::size_t k = 0; k < fans.size(); ++k) {
        for (std::size_t s = 0; s < regions[k].size(); ++s) {
            const Sector& sector = fans[k].sectors()[s];
            for (int p = 0; p < regions[k][s].a; ++p)
                for (int q = 0; q < regions[k][s].b; ++q)
                    fans_[std::size_t(sector.surface())][std::size_t(sector.span(p, q))]
                         [std::size_t(sector.corner())] = int(k);
        }
    }
}

bool CornerFans::share_fan(int surface_a, int span_a, int surface_b, int span_b) const {
    const Fans& a = fans_[std::size_t(surface_a)][std::size_t(span_a)];
    const Fans& b = fans_[std::size_t(surface_b)][std::size_t(span_b)];
    for (const int fan : a)
        if (fan >= 0 && std::find(b.begin(), b.end(), fan) != b.end()) return true;
    return false;
}

}  // namespace patchwright::measure
