#include "cage/blocks/block_grid.h"

#include "cage/blocks/line_shares.h"
#include "cage/blocks/shape_quads.h"
#include "cage/blocks/untangle.h"
#include "cage/field/block_map.h"

#include <patchwright/base/numbers.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Share of quads that fold: above the first one moving points opens some of them only and is not
// worth its time, nor are finer edges; above the second one, after it, other ways are not tried.
constexpr double most_folded = 0.04, most_left = 0.01;
// Rounds in which points are evened out, and their share of the way to their neighbours' middle.
constexpr int evening_rounds = 12;
constexpr double evening_share = 0.5;
// Least sine of a point's angles (24 degrees) that evening out may leave where there was more.
constexpr double good_enough = 0.4;
// A corner with a smaller sine counts as concave (1 degree); one may be, up to 210 degrees: the fit
// makes that good.
constexpr double least_convex = 0.02, most_concave = -0.5;

class Gridder {
  public:
    Gridder(const QuadLayout& layout, const Divisions& divisions,
            const geom::ModelSurface& reference, Poll& poll, const SizeMetric* metric)
        : layout_(layout), divisions_(divisions), reference_(reference), poll_(poll) {
        if (metric != nullptr) map_.emplace(layout, divisions, *metric, poll);
    }

    Blocks make(const std::vector<std::string>& names) {
        for (const LayoutNode& node : layout_.nodes) {
            if (node.corner) blocks_.corners.push_back(int(blocks_.points.size()));
            add_point(node.point, {!node.held, node.curve});
        }
        for (std::size_t a = 0; a < layout_.arcs.size(); ++a) add_arc(int(a), divisions_.edges[a]);
        for (std::size_t b = 0; b < layout_.blocks.size(); ++b)
            add_block(layout_.blocks[b], divisions_.insertions[b]);
        if (map_)
            shape_quads({blocks_.faces, freedom_, blocks_.creases, normals_}, blocks_.points,
                        reference_, poll_);
        else
            open_folds();
        check();
        for (std::size_t f = 0; f < blocks_.faces.size(); ++f) {
            const geom::FootPoint foot = reference_.foot_point(middle(f), area(f).normalized());
            blocks_.groups.push_back(names[at(std::max(foot.face, 0))]);
        }
        return std::move(blocks_);
    }

  private:
    /// What sticks out loses its points to its foot unless they are kept within the surface; in
    /// hollows it is the other way round. Where many quads fold, moving points opens some of them
    /// only. Points stay where fewest quads fold.
    void open_folds() {
        const auto too_many = [&](std::size_t count, double share) {
            return double(count) > std::ceil(share * double(blocks_.faces.size()));
        };
        const std::vector<Vec3> before = blocks_.points;
        std::vector<Vec3> best = before;
        std::size_t least = folded().size();
        const auto count_and_keep = [&] {
            const std::size_t count = folded().size();
            if (count <= least) {
                least = count;
                best = blocks_.points;
            }
            return count;
        };
        for (const bool within : {true, false}) {
            blocks_.points = before;
            even_out(within);
            if (too_many(count_and_keep(), most_folded)) break;
            untangle(blocks_.faces, blocks_.points, freedom_, reference_, poll_);
            if (too_many(count_and_keep(), most_left) || least == 0) break;
        }
        blocks_.points = std::move(best);
    }

    int add_point(const Vec3& p, const Freedom& freedom) {
        blocks_.points.push_back(p);
        freedom_.push_back(freedom);
        return int(blocks_.points.size()) - 1;
    }

    [[nodiscard]] Vec3 on_piece(int piece, const Vec2& p) const {
        poll_();
        const FlatPiece::SurfacePoint place = layout_.pieces[at(piece)].at(p);
        return reference_.foot_point(place.point, place.normal).point;
    }

    void move_node(int number, const Vec3& p) {
        const LayoutNode& node = layout_.nodes[at(number)];
        if (node.corner) return;
        if (node.held && node.curve < 0) return;
        blocks_.points[at(number)] = node.curve >= 0
                                         ? reference_.nearest_on_curve(node.curve, p).point
                                         : reference_.foot_point(p).point;
    }

    void add_arc(int number, int count) {
        const LayoutArc& arc = layout_.arcs[at(number)];
        std::vector<int> line{arc.start};
        const std::vector<double> shares =
            arc.piece >= 0 ? even_shares(count) : graded_shares(arc.points, count);
        const bool mapped = map_ && arc.piece < 0;
        const std::vector<Vec3> points =
            mapped ? map_->along(number) : resampled(arc.points, shares);
        if (mapped) {
            move_node(arc.start, points.front());
            move_node(arc.end, points.back());
        }
        for (int k = 1; k < count; ++k) {
            const Vec3 p =
                arc.curve >= 0 ? reference_.nearest_on_curve(arc.curve, points[at(k)]).point
                : arc.piece >= 0
                    ? on_piece(arc.piece, arc.from + (arc.to - arc.from) * (double(k) / count))
                    : reference_.foot_point(points[at(k)]).point;
            line.push_back(add_point(p, {arc.curve < 0, arc.curve}));
        }
        line.push_back(arc.end);
        for (int k = 0; k < count && arc.crease; ++k)
            blocks_.creases.emplace_back(line[at(k)], line[at(k + 1)]);
        lines_.push_back(std::move(line));
        shares_.push_back(mapped ? shares_of(points) : shares);
    }

    /// A vertex and where it is on the flat piece.
    struct GridSpot {
        int vertex;
        Vec2 flat;
    };
    using Line = std::vector<GridSpot>;

    /// Vertices along a side, both corners included.
    /// @param end  where the side ends on the flat piece
    [[nodiscard]] Line along(const BlockSide& side, const std::vector<Vec2>& flat,
                             const Vec2& end) const {
        Line result;
        for (std::size_t i = 0; i < side.size(); ++i) {
            std::vector<int> line = lines_[at(side[i].arc)];
            std::vector<double> share = shares_[at(side[i].arc)];
            if (side[i].reversed) {
                std::reverse(line.begin(), line.end());
                std::reverse(share.begin(), share.end());
                for (double& s : share) s = 1.0 - s;
            }
            if (!result.empty() && result.back().vertex != line.front())
                throw LayoutRefused{"arcs of a side do not meet"};
            if (!result.empty()) result.pop_back();
            const Vec2 &from = flat[i], &to = i + 1 < side.size() ? flat[i + 1] : end;
            for (std::size_t k = 0; k < line.size(); ++k)
                result.push_back({line[k], from + (to - from) * share[k]});
        }
        return result;
    }

    void add_block(const LayoutBlock& block, const Valence3Insertion& insertion) {
        piece_ = block.piece;
        block_ = int(&block - layout_.blocks.data());
        std::array<Line, 4> sides;
        for (int k = 0; k < 4; ++k) {
            const int s = (insertion.side + k) % 4;
            sides[at(k)] =
                along(block.sides[at(s)], block.flat[at(s)], block.flat[at((s + 1) % 4)].front());
        }
        if (insertion.count == 0) {
            add_grid(sides);
            return;
        }
        // Corners a, b, c, d; strips go around b, and a line leads from d to the middle x.
        const auto t = std::ptrdiff_t(insertion.count);
        const auto& [ab, bc, cd, da] = sides;
        if (std::ptrdiff_t(ab.size()) != std::ptrdiff_t(cd.size()) + t ||
            std::ptrdiff_t(bc.size()) != std::ptrdiff_t(da.size()) + t)
            throw LayoutRefused{"sides of a block do not meet"};
        const GridSpot m = ab[at(insertion.count)], q = bc[bc.size() - 1 - at(insertion.count)],
                       d = cd.back();
        const Vec2 middle = (m.flat + q.flat + d.flat) / 3.0;
        const GridSpot x{add_point(on_piece(piece_, middle), {}), middle};
        const auto line = [&](const GridSpot& from, int count) {
            Line result{from};
            for (int k = 1; k < count; ++k) {
                const Vec2 p = from.flat + (x.flat - from.flat) * (double(k) / count);
                result.push_back({add_point(on_piece(piece_, p), {}), p});
            }
            result.push_back(x);
            return result;
        };
        const auto reversed = [](Line l) {
            std::reverse(l.begin(), l.end());
            return l;
        };
        const Line mx = line(m, int(da.size()) - 1), qx = line(q, int(cd.size()) - 1),
                   dx = line(d, insertion.count);
        const Line am(ab.begin(), ab.begin() + t + 1), mb(ab.begin() + t, ab.end());
        const Line bq(bc.begin(), bc.end() - t), qc(bc.end() - t - 1, bc.end());
        add_grid({am, mx, reversed(dx), da});
        add_grid({mb, bq, qx, reversed(mx)});
        add_grid({qc, cd, dx, reversed(qx)});
    }

    /// @param sides  counter-clockwise, with both corners
    void add_grid(const std::array<Line, 4>& sides) {
        const Line &bottom = sides[0], &right = sides[1];
        Line top = sides[2], left = sides[3];
        std::reverse(top.begin(), top.end());
        std::reverse(left.begin(), left.end());
        if (bottom.front().vertex != left.front().vertex ||
            bottom.back().vertex != right.front().vertex ||
            top.front().vertex != left.back().vertex || top.back().vertex != right.back().vertex ||
            bottom.size() != top.size() || left.size() != right.size())
            throw LayoutRefused{"sides of a block do not meet"};
        const int m = int(bottom.size()) - 1, n = int(left.size()) - 1;
        const auto sb = shares(bottom), st = shares(top), sl = shares(left), sr = shares(right);
        const auto flat = [&](double u, double w) -> Vec2 {
            return (1 - u) * (1 - w) * bottom.front().flat + u * (1 - w) * bottom.back().flat +
                   (1 - u) * w * top.front().flat + u * w * top.back().flat;
        };
        std::vector<std::vector<int>> grid(at(n + 1), std::vector<int>(at(m + 1), -1));
        for (int j = 0; j <= n; ++j) {
            for (int i = 0; i <= m; ++i) {
                int& v = grid[at(j)][at(i)];
                if (j == 0)
                    v = bottom[at(i)].vertex;
                else if (j == n)
                    v = top[at(i)].vertex;
                else if (i == 0)
                    v = left[at(j)].vertex;
                else if (i == m)
                    v = right[at(j)].vertex;
                if (v >= 0) continue;
                // Where the lines between equal shares cross, in the quad of the corners.
                const double du = st[at(i)] - sb[at(i)], dv = sr[at(j)] - sl[at(j)];
                const double u = (sb[at(i)] + sl[at(j)] * du) / (1.0 - du * dv);
                const double w = sl[at(j)] + u * dv;
                if (map_ && map_->has(block_)) {
                    const FlatPiece::SurfacePoint place = map_->point(block_, Vec2(i, j));
                    v = add_point(reference_.foot_point(place.point, place.normal).point, {});
                } else {
                    v = add_point(on_piece(piece_, flat(u, w)), {});
                }
            }
        }
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < m; ++i) {
                blocks_.faces.push_back({grid[at(j)][at(i)], grid[at(j)][at(i + 1)],
                                         grid[at(j + 1)][at(i + 1)], grid[at(j + 1)][at(i)]});
                const Vec2 u(i + 0.5, j + 0.5);
                normals_.push_back(
                    map_ && map_->has(block_)
                        ? map_->point(block_, u).normal
                        : layout_.pieces[at(piece_)].at(flat(u.x() / m, u.y() / n)).normal);
            }
    }

    static std::vector<double> shares(const Line& line) {
        std::vector<Vec3> points;
        for (const GridSpot& s : line) points.emplace_back(s.flat.x(), s.flat.y(), 0.0);
        return shares_of(points);
    }

    [[nodiscard]] Vec3 point(std::size_t face, int k) const {
        return blocks_.points[at(blocks_.faces[face][at((k + 4) % 4)])];
    }
    [[nodiscard]] Vec3 area(std::size_t f) const {
        return 0.5 * (point(f, 2) - point(f, 0)).cross(point(f, 3) - point(f, 1));
    }
    [[nodiscard]] Vec3 middle(std::size_t f) const {
        return 0.25 * (point(f, 0) + point(f, 1) + point(f, 2) + point(f, 3));
    }

    [[nodiscard]] double least_sine(std::size_t f) const {
        const Vec3 normal = area(f).normalized();
        double least = 1.0;
        for (int k = 0; k < 4; ++k)
            least = std::min(least, corner_sine(blocks_.points, blocks_.faces[f], k, normal));
        return least;
    }

    /// Moves points between their neighbours as long as no quad becomes too sharp by it.
    void even_out(bool within) {
        std::vector<std::vector<int>> next(blocks_.points.size());
        std::vector<std::vector<std::size_t>> faces(blocks_.points.size());
        for (std::size_t f = 0; f < blocks_.faces.size(); ++f) {
            const auto& face = blocks_.faces[f];
            for (std::size_t k = 0; k < 4; ++k) {
                next[at(face[k])].push_back(face[(k + 1) % 4]);
                faces[at(face[k])].push_back(f);
            }
        }
        const auto worst = [&](std::size_t v) {
            double least = 1.0;
            for (const std::size_t f : faces[v]) least = std::min(least, least_sine(f));
            return least;
        };
        std::vector<Vec3> up(blocks_.points.size());
        for (std::size_t v = 0; v < freedom_.size(); ++v) {
            Vec3 normal = Vec3::Zero();
            for (const std::size_t f : faces[v]) normal += area(f);
            normal.normalize();
            up[v] = (normal.norm() > 0.5 ? reference_.foot_point(blocks_.points[v], normal)
                                         : reference_.foot_point(blocks_.points[v]))
                        .normal;
        }
        for (int round = 0; round < evening_rounds; ++round) {
            for (std::size_t v = 0; v < freedom_.size(); ++v) {
                if (!freedom_[v].free || !(up[v].norm() > 0.5)) continue;
                poll_();
                const double before = worst(v);
                const Vec3 old = blocks_.points[v];
                Vec3 sum = Vec3::Zero();
                for (const int w : next[v]) sum += blocks_.points[at(w)];
                Vec3 step = evening_share * (sum / double(next[v].size()) - old);
                if (within) step -= step.dot(up[v]) * up[v];
                const geom::FootPoint foot = reference_.foot_point(old + step, up[v]);
                blocks_.points[v] = foot.point;
                if (foot.normal.dot(up[v]) < 0.0 || worst(v) < std::min(before, good_enough))
                    blocks_.points[v] = old;
                else
                    up[v] = foot.normal;
            }
        }
    }

    /// Quads must face as the model does and may be concave a little, at one corner: the fit makes
    /// that good. What has two such corners is folded.
    [[nodiscard]] bool folds(std::size_t f) const {
        poll_();
        const Vec3 normal = area(f).normalized();
        int concave = 0;
        for (int k = 0; k < 4; ++k)
            concave += corner_sine(blocks_.points, blocks_.faces[f], k, normal) < least_convex;
        return concave > 1 || least_sine(f) < most_concave ||
               reference_.foot_point(middle(f), normal).normal.dot(normal) <= 0.0;
    }

    [[nodiscard]] std::vector<std::size_t> folded() const {
        std::vector<std::size_t> result;
        for (std::size_t f = 0; f < blocks_.faces.size(); ++f)
            if (folds(f)) result.push_back(f);
        return result;
    }

    void check() const {
        const auto bad = folded();
        if (bad.empty()) return;
        const Vec3 first = middle(bad[0]);
        const bool many = double(bad.size()) > most_folded * double(blocks_.faces.size());
        throw LayoutRefused{
            fmt::format("{} of {} quads fold, one near ({:.4g}, {:.4g}, {:.4g})", bad.size(),
                        blocks_.faces.size(), first.x(), first.y(), first.z()),
            map_ && many};
    }

    const QuadLayout& layout_;
    const Divisions& divisions_;
    const geom::ModelSurface& reference_;
    Poll& poll_;
    std::optional<BlockMap> map_;
    int block_ = -1;
    Blocks blocks_;
    std::vector<Freedom> freedom_;
    std::vector<Vec3> normals_;                ///< of the model, one a face
    std::vector<std::vector<int>> lines_;      ///< points of each arc
    std::vector<std::vector<double>> shares_;  ///< and where on it they are, 0 to 1
    int piece_ = -1;                           ///< of the block at hand
};

}  // namespace

Blocks block_grid(const QuadLayout& layout, const Divisions& divisions,
                  const geom::ModelSurface& reference, const std::vector<std::string>& face_names,
                  Poll& poll, const SizeMetric* metric) {
    return Gridder(layout, divisions, reference, poll, metric).make(face_names);
}

}  // namespace patchwright::cage
