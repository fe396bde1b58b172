#include "cage/blocks/block_grid.h"

#include "cage/blocks/folded_quads.h"
#include "cage/blocks/line_shares.h"
#include "cage/blocks/untangle.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Share of quads that fold above which, after points were moved, other ways are not tried.
constexpr double most_left = 0.01;
// Rounds in which points are evened out, and their share of the way to their neighbours' middle.
constexpr int evening_rounds = 12;
constexpr double evening_share = 0.5;
// Least sine of a point's angles (24 degrees) that evening out may leave where there was more.
constexpr double good_enough = 0.4;

class Gridder {
  public:
    Gridder(const QuadLayout& layout, const Divisions& divisions,
            const geom::ModelSurface& reference, Poll& poll)
        : layout_(layout), divisions_(divisions), reference_(reference), poll_(poll) {}

    Blocks make() {
        for (const LayoutNode& node : layout_.nodes) {
            if (node.corner) blocks_.corners.push_back(int(blocks_.points.size()));
            add_point(node.point, {!node.held, node.curve});
        }
        for (std::size_t a = 0; a < layout_.arcs.size(); ++a) add_arc(int(a), divisions_.edges[a]);
        for (std::size_t b = 0; b < layout_.blocks.size(); ++b)
            add_block(layout_.blocks[b], divisions_.insertions[b]);
        open_folds();
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
        std::size_t least = folded_quads(blocks_, reference_, poll_).size();
        const auto count_and_keep = [&] {
            const std::size_t count = folded_quads(blocks_, reference_, poll_).size();
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

    void add_arc(int number, int count) {
        const LayoutArc& arc = layout_.arcs[at(number)];
        std::vector<int> line{arc.start};
        const std::vector<double> shares =
            arc.piece >= 0 ? even_shares(count) : graded_shares(arc.points, count);
        const std::vector<Vec3> points = resampled(arc.points, shares);
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
        shares_.push_back(shares);
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
                v = add_point(on_piece(piece_, flat(u, w)), {});
            }
        }
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < m; ++i)
                blocks_.faces.push_back({grid[at(j)][at(i)], grid[at(j)][at(i + 1)],
                                         grid[at(j + 1)][at(i + 1)], grid[at(j + 1)][at(i)]});
    }

    static std::vector<double> shares(const Line& line) {
        std::vector<Vec3> points;
        for (const GridSpot& s : line) points.emplace_back(s.flat.x(), s.flat.y(), 0.0);
        return shares_of(points);
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
            for (const std::size_t f : faces[v]) least = std::min(least, least_sine(blocks_, f));
            return least;
        };
        std::vector<Vec3> up(blocks_.points.size());
        for (std::size_t v = 0; v < freedom_.size(); ++v) {
            Vec3 normal = Vec3::Zero();
            for (const std::size_t f : faces[v]) normal += quad_area(blocks_, f);
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

    const QuadLayout& layout_;
    const Divisions& divisions_;
    const geom::ModelSurface& reference_;
    Poll& poll_;
    Blocks blocks_;
    std::vector<Freedom> freedom_;
    std::vector<std::vector<int>> lines_;      ///< points of each arc
    std::vector<std::vector<double>> shares_;  ///< and where on it they are, 0 to 1
    int piece_ = -1;                           ///< of the block at hand
};

}  // namespace

Blocks block_grid(const QuadLayout& layout, const Divisions& divisions,
                  const geom::ModelSurface& reference, const std::vector<std::string>& face_names,
                  Poll& poll) {
    return checked(Gridder(layout, divisions, reference, poll).make(), reference, face_names, false,
                   poll);
}

}  // namespace patchwright::cage
