#include "measure/deviation_bound.h"

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace patchwright::measure {

using geom::Vec3;

namespace {

constexpr double safety = 1.5;

/// A corner on the surface with its foot on the other model.
struct Corner {
    Eigen::Vector2d uv;
    Vec3 point, foot;
    double distance = 0.0;
};

/// A piece of a face over a triangle of the parameter plane.
struct Piece {
    int face = -1;
    double beside = 0.0;  ///< what a triangle at a curved border leaves out
    std::array<Corner, 3> corner;
    double bound = 0.0;

    bool operator<(const Piece& other) const { return bound < other.bound; }
};

class Bounding {
  public:
    Bounding(const geom::ModelSurface& from, const geom::ModelSurface& to) : from_(from), to_(to) {}

    [[nodiscard]] Piece whole(const geom::SurfacePiece& t) const {
        Piece piece{t.face, t.beside, {}, 0.0};
        for (std::size_t k = 0; k < 3; ++k) piece.corner[k] = corner(t.face, t.uv[k]);
        piece.bound = bound(piece);
        return piece;
    }

    [[nodiscard]] std::array<Piece, 4> quarters(const Piece& piece) const {
        std::array<Corner, 3> side;
        for (std::size_t k = 0; k < 3; ++k)
            side[k] = corner(piece.face, 0.5 * (piece.corner[k].uv + piece.corner[(k + 1) % 3].uv));
        std::array<Piece, 4> parts;
        parts.fill(piece);
        for (std::size_t k = 0; k < 3; ++k)
            parts[k].corner = {piece.corner[k], side[k], side[(k + 2) % 3]};
        parts[3].corner = side;
        for (Piece& part : parts) part.bound = bound(part);
        return parts;
    }

  private:
    [[nodiscard]] Corner corner(int face, const Eigen::Vector2d& uv) const {
        Corner result;
        result.uv = uv;
        result.point = from_.point_on_face(face, uv);
        const auto foot = to_.foot_point(result.point);
        result.foot = foot.point;
        result.distance = foot.distance;
        return result;
    }

    [[nodiscard]] double bound(const Piece& piece) const {
        const auto& [a, b, c] = piece.corner;
        double largest = std::max({a.distance, b.distance, c.distance}), uneven = 0.0;
        constexpr double half = 0.5, third = 1.0 / 3.0;
        for (const Vec3& w : {Vec3(half, half, 0), Vec3(0, half, half), Vec3(half, 0, half),
                              Vec3(third, third, third)}) {
            const Corner inner = corner(piece.face, w[0] * a.uv + w[1] * b.uv + w[2] * c.uv);
            const Vec3 between =
                w[0] * (a.point - a.foot) + w[1] * (b.point - b.foot) + w[2] * (c.point - c.foot);
            largest = std::max(largest, inner.distance);
            uneven = std::max(uneven, (inner.point - inner.foot - between).norm());
        }
        return largest + safety * uneven + piece.beside;
    }

    const geom::ModelSurface& from_;
    const geom::ModelSurface& to_;
};

}  // namespace

double deviation_bound(const geom::ModelSurface& from, const geom::ModelSurface& to,
                       const DeviationBoundOptions& options) {
    const std::vector<geom::SurfacePiece> triangles = from.pieces();
    const Bounding bounding(from, to);
    std::vector<Piece> pieces(triangles.size());
    constexpr std::size_t block = 16384, grain = 64;
    for (std::size_t start = 0; start < pieces.size(); start += block) {
        base::report_progress(options.progress, "bound", double(start) / double(pieces.size()));
        const std::size_t count = std::min(block, pieces.size() - start);
        base::parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = start + begin; i < start + end; ++i)
                pieces[i] = bounding.whole(triangles[i]);
        });
    }
    const double found = options.at_least;
    const double enough = found + std::max(options.slack_rel * found, options.slack_mm);
    // What lies beside triangles does not get smaller, and below that nothing is gained.
    double settled = enough;
    for (const Piece& piece : pieces) settled = std::max(settled, found + piece.beside);
    double worst = found;
    // Rounds of quartering all that is above the goal: the same with any number of threads.
    for (int left = options.max_refinements; left > 0 && !pieces.empty();) {
        std::vector<Piece> open;
        for (const Piece& piece : pieces) {
            if (piece.bound > settled)
                open.push_back(piece);
            else
                worst = std::max(worst, piece.bound);
        }
        std::stable_sort(open.begin(), open.end(),
                         [](const Piece& a, const Piece& b) { return b < a; });
        const auto count = std::min(open.size(), std::size_t(left));
        left -= int(count);
        std::vector<std::array<Piece, 4>> parts(count);
        base::parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) parts[i] = bounding.quarters(open[i]);
        });
        pieces.assign(open.begin() + std::ptrdiff_t(count), open.end());
        for (const auto& four : parts) pieces.insert(pieces.end(), four.begin(), four.end());
    }
    for (const Piece& piece : pieces) worst = std::max(worst, piece.bound);
    base::report_progress(options.progress, "bound", 1.0);
    return worst;
}

}  // namespace patchwright::measure
