#include "cage/blocks/cuts.h"

#include "geom/angle.h"
#include "geom/shortest_paths.h"

#include <patchwright/base/numbers.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using base::at;
using base::infinity;
using geom::Vec3;

namespace {

// How far a side may bend inward (by itself, in triangles and so on; against the opposite one in
// blocks) before it needs a line from its middle: 112 degrees, which leaves quads 34 on either
// side.
constexpr double most_inward = 1.95;
// Share of such a side's turn from either end within which that line does not begin: it would still
// bend too much beyond.
constexpr double inner_turn = 0.25;
// Border points from which cuts are tried, by border: one in so many that there are about these.
constexpr int most_sources = 32;
// An end of a cut costs the square of its angle's error in these units (34 degrees), and so much at
// a corner, which it would part; it gains by starting where a corner needs more than one quad.
constexpr double angle_unit_rad = 0.6, at_corner = 2.0, from_reflex = -1.0;
// A cut costs this in lengths of the root of the piece's area; it gains by joining two borders and
// by ends on nodes.
constexpr double by_length = 0.7, other_border = -0.5, has_node = -0.15;
// All gains together: a cut that costs more by its length alone need not be looked at.
constexpr double most_gained = -(2.0 * from_reflex + other_border + 2.0 * has_node);
// Above the rounding of lengths and costs.
constexpr double rounding_rel = 1e-12;
// A cut that ends this near to a node, of its length, leaves a sliver of a block and costs so much.
constexpr double node_reach = 0.3, node_penalty = 0.8;
// Of the difference from four corners, squared, on either side.
constexpr double corner_weight = 0.25;
// Share of a cut's length over which its direction is taken: it goes by edges, which zigzag.
constexpr double direction_share = 0.35;

/// A side of a disc, from corner to corner.
struct SideOf {
    int first = 0, count = 0;  ///< border points; the first one is the corner
    double turn = 0.0;         ///< to the left, radians, without the corners
};

std::vector<SideOf> sides_of(const Border& border) {
    std::vector<SideOf> sides;
    const int n = int(border.size());
    const int start = first_corner(border);
    if (start < 0) {
        SideOf whole{0, n, 0.0};
        for (const BorderPoint& p : border) whole.turn += M_PI - p.angle;
        return {whole};
    }
    for (int k = 0; k < n; ++k) {
        const int i = (start + k) % n;
        if (border[at(i)].faces == 1) sides.push_back({i, 0, 0.0});
        SideOf& side = sides.back();
        if (side.count++ > 0) side.turn += M_PI - border[at(i)].angle;
    }
    return sides;
}

int corner_count(const Border& border) {
    return int(std::count_if(border.begin(), border.end(),
                             [](const BorderPoint& p) { return p.faces == 1; }));
}

bool has_reflex(const CutPiece& piece) {
    for (const Border& border : piece.borders)
        for (const BorderPoint& p : border)
            if (p.faces > 2) return true;
    return false;
}

/// The side that needs a line from its middle; nothing when none does.
std::optional<SideOf> hollow_side(const Border& border) {
    const auto sides = sides_of(border);
    std::optional<SideOf> worst;
    double least = -most_inward;
    for (std::size_t k = 0; k < sides.size(); ++k) {
        const double against = sides.size() == 4 ? sides[(k + 2) % 4].turn : 0.0;
        const double turn = sides[k].turn + against;
        if (turn < least && sides[k].turn < 0.0) {
            least = turn;
            worst = sides[k];
        }
    }
    return worst;
}

/// Directions along the border at each point.
class Directions {
  public:
    Directions(const CutPiece& piece, const geom::EditableMesh& mesh)
        : piece_(piece), mesh_(mesh) {}

    /// Share of the angle at border point i, from the way onward to the way d, 0 to 1.
    [[nodiscard]] double share(int i, const Vec3& d) const {
        const Vec3 onward = way(i, 1), back = way(i, -1);
        const double right = geom::angle_between(onward, d), left = geom::angle_between(back, d);
        return right + left > 0.0 ? right / (right + left) : 0.5;
    }

  private:
    [[nodiscard]] Vec3 way(int i, int step) const {
        const auto& [border, number] = piece_.border_places[at(i)];
        const Border& b = piece_.borders[at(border)];
        const int n = int(b.size());
        return mesh_.point(b[at((number + step + n) % n)].vertex) -
               mesh_.point(b[at(number)].vertex);
    }

    const CutPiece& piece_;
    const geom::EditableMesh& mesh_;
};

/// No end of a cut at this point costs less.
double least_end_cost(const BorderPoint& p) {
    if (p.faces == 1) return at_corner;
    return p.faces > 2 ? from_reflex : 0.0;
}

/// How a way that leaves border point p at this share of its angle parts it, and what that costs.
struct CutEnd {
    Parting parting;
    double cost = 0.0;
};

CutEnd end_at(const BorderPoint& p, double share) {
    CutEnd end{{.angle = share * p.angle}, least_end_cost(p)};
    double part = 0.5;
    if (p.faces > 1) {
        end.parting.faces = std::clamp(int(std::lround(share * p.faces)), 1, p.faces - 1);
        end.parting.faces_after = p.faces - end.parting.faces;
        part = double(end.parting.faces) / p.faces;
    }
    end.cost += std::pow((share - part) * p.angle / angle_unit_rad, 2.0);
    return end;
}

/// Sum of (2 - faces) along a border from point i to before point j.
int turns_between(const Border& border, int i, int j) {
    int sum = 0;
    const int n = int(border.size());
    for (int k = i; k != j; k = (k + 1) % n) sum += 2 - border[at(k)].faces;
    return sum;
}

class CutSearch {
  public:
    CutSearch(const CutPiece& piece, const PieceMesh& mesh, Poll& poll)
        : piece_(piece),
          mesh_(mesh),
          poll_(poll),
          directions_(piece, mesh.mesh()),
          scale_(std::sqrt(std::max(piece.area, 1e-300))),
          search_(piece.vertices.size()) {
        measure_to_nodes();
        count_corners();
    }

    Cut best() {
        double least = infinity;
        std::optional<Cut> best;
        for (const int source : sources()) {
            poll_();
            const double longest = (least + most_gained) * scale_ / by_length;
            for (const int target : targets_from(source, (1.0 + rounding_rel) * longest)) {
                if (!allowed(source, target)) continue;
                if (auto cut = judge(source, target, least)) best = std::move(cut);
            }
        }
        if (!best) throw LayoutRefused{fmt::format("no cut was found through {}", describe())};
        return std::move(*best);
    }

  private:
    /// The other border points, in ascending order, with ways through the inside that are not
    /// longer than this.
    [[nodiscard]] std::vector<int> targets_from(int source, double longest) {
        const int border = piece_.border_count();
        search_.run({{source, 0.0}}, [&](int i, double length, const auto& reach) {
            if (i < border && i != source) return;
            for (const auto& [j, step] : piece_.neighbours[at(i)])
                if (length + step <= longest) reach(j, length + step);
        });
        std::vector<int> targets;
        for (const int i : search_.reached())
            if (i < border && i != source) targets.push_back(i);
        std::sort(targets.begin(), targets.end());
        return targets;
    }

    [[nodiscard]] std::string describe() const {
        int corners = 0;
        for (const Border& b : piece_.borders) corners += corner_count(b);
        const Vec3 p = mesh_.mesh().point(piece_.vertices.empty() ? 0 : piece_.vertices[0]);
        return fmt::format("a face with {} borders and {} corners near ({:.4g}, {:.4g}, {:.4g})",
                           piece_.borders.size(), corners, p.x(), p.y(), p.z());
    }

    /// Along the border to the next node.
    void measure_to_nodes() {
        for (const Border& border : piece_.borders) {
            const int n = int(border.size());
            std::vector<double> distance(border.size(), infinity);
            for (int i = 0; i < n; ++i)
                if (border[at(i)].node) distance[at(i)] = 0.0;
            const auto relax = [&](int i, int j) {
                const double step = (mesh_.mesh().point(border[at(i)].vertex) -
                                     mesh_.mesh().point(border[at(j)].vertex))
                                        .norm();
                distance[at(j)] = std::min(distance[at(j)], distance[at(i)] + step);
            };
            for (int k = 0; k < 2 * n; ++k) relax(k % n, (k + 1) % n);
            for (int k = 2 * n; k > 0; --k) relax(k % n, (k + n - 1) % n);
            to_node_.insert(to_node_.end(), distance.begin(), distance.end());
        }
    }

    void count_corners() {
        corners_before_ = {0};
        for (int i = 0; i < piece_.border_count(); ++i)
            corners_before_.push_back(corners_before_.back() +
                                      (piece_.border_point(i).faces != 2 ? 1 : 0));
    }

    /// Every how many points one is looked at, and numbers of border points.
    [[nodiscard]] std::vector<int> sources() {
        std::vector<int> result;
        int base = 0;
        for (const Border& border : piece_.borders) {
            for (std::size_t i = 0; i < border.size(); ++i)
                if (border[i].faces > 2) result.push_back(base + int(i));
            base += int(border.size());
        }
        if (!result.empty()) return result;
        if (piece_.borders.size() > 1) {
            base = 0;
            const int outer = longest_border();
            for (std::size_t b = 0; b < piece_.borders.size(); ++b) {
                const int n = int(piece_.borders[b].size());
                for (int i = 0; i < n && int(b) != outer; ++i)
                    if (piece_.borders[b][at(i)].faces > 1 &&
                        (piece_.borders[b][at(i)].node || i % (1 + n / most_sources) == 0))
                        result.push_back(base + i);
                base += n;
            }
            return result;
        }
        const Border& border = piece_.borders[0];
        const int n = int(border.size());
        if (const auto side = hollow_side(border)) {
            double turn = 0.0;
            for (int k = 1; k < side->count; ++k) {
                const int i = (side->first + k) % n;
                turn += M_PI - border[at(i)].angle;
                const double share = turn / side->turn;
                if (share > inner_turn && share < 1.0 - inner_turn) result.push_back(i);
            }
            if (!result.empty()) return result;
        }
        for (int i = 0; i < n; ++i)
            if (border[at(i)].faces == 2 && (border[at(i)].node || i % (1 + n / most_sources) == 0))
                result.push_back(i);
        return result;
    }

    [[nodiscard]] int longest_border() const {
        int longest = 0;
        double most = -1.0;
        for (std::size_t b = 0; b < piece_.borders.size(); ++b) {
            double length = 0.0;
            for (const BorderPoint& p : piece_.borders[b])
                length += (mesh_.mesh().point(p.vertex) - mesh_.mesh().point(p.next)).norm();
            if (length > most) {
                most = length;
                longest = int(b);
            }
        }
        return longest;
    }

    [[nodiscard]] bool allowed(int source, int target) const {
        const auto& [border, number] = piece_.border_places[at(source)];
        if (border != piece_.border_of(target)) return true;
        if (piece_.borders.size() > 1 && piece_.border_point(source).faces <= 2) return false;
        // Points of one side would leave a piece without corners.
        const auto corners = [&](int from, int to) {
            return corners_before_[at(to)] - corners_before_[at(from)];
        };
        const auto [low, high] = std::minmax(source, target);
        const int first = source - number, last = first + int(piece_.borders[at(border)].size());
        return corners(low + 1, high) > 0 && corners(first, low) + corners(high + 1, last) > 0;
    }

    [[nodiscard]] double near_node(int point, double length) const {
        const double d = to_node_[at(point)];
        if (d <= 0.0 || !(d < node_reach * length)) return 0.0;
        return node_penalty * (1.0 - d / (node_reach * length));
    }

    /// What is far from four corners on both sides of a cut through a disc.
    [[nodiscard]] double corner_cost(int source, int target, const CutEnd& start,
                                     const CutEnd& end) const {
        if (piece_.borders.size() != 1) return 0.0;
        const Border& border = piece_.borders[0];
        const int n = int(border.size());
        // The side after the source and before the target, then the other one.
        const int one = turns_between(border, (source + 1) % n, target) + 4 - start.parting.faces -
                        end.parting.faces_after;
        const int other = turns_between(border, (target + 1) % n, source) + 4 -
                          start.parting.faces_after - end.parting.faces;
        return corner_weight * ((one - 4) * (one - 4) + (other - 4) * (other - 4));
    }

    std::optional<Cut> judge(int source, int target, double& least) const {
        const geom::ShortestPaths& search = search_.paths();
        const double length = search.length[at(target)];
        double cost = by_length * length / scale_;
        if (cost - most_gained > least) return std::nullopt;
        cost += near_node(source, length) + near_node(target, length);
        for (const int i : {source, target})
            if (to_node_[at(i)] <= 0.0) cost += has_node;
        if (piece_.border_of(source) != piece_.border_of(target)) cost += other_border;
        if (cost + least_end_cost(piece_.border_point(source)) +
                least_end_cost(piece_.border_point(target)) >
            least + rounding_rel)
            return std::nullopt;
        PiecePath path = search.path_to(target);
        const auto point = [&](double share) {
            Vec3 p = mesh_.mesh().point(piece_.vertices[at(path.front())]);
            for (std::size_t k = 1; k < path.size(); ++k) {
                const double l0 = search.length[at(path[k - 1])], l1 = search.length[at(path[k])];
                const Vec3 next = mesh_.mesh().point(piece_.vertices[at(path[k])]);
                if (l1 >= share * length)
                    return Vec3(p + (next - p) * ((share * length - l0) / (l1 - l0)));
                p = next;
            }
            return p;
        };
        const Vec3 from_start = point(direction_share) - point(0.0),
                   from_end = point(1.0 - direction_share) - point(1.0);
        const CutEnd start =
            end_at(piece_.border_point(source), directions_.share(source, from_start));
        const CutEnd end = end_at(piece_.border_point(target), directions_.share(target, from_end));
        cost += start.cost + end.cost + corner_cost(source, target, start, end);
        if (cost >= least) return std::nullopt;
        least = cost;
        return Cut{std::move(path), start.parting, end.parting};
    }

    const CutPiece& piece_;
    const PieceMesh& mesh_;
    Poll& poll_;
    Directions directions_;
    double scale_;
    std::vector<double> to_node_;
    std::vector<int> corners_before_;  ///< each border point; of one quad or several
    geom::PathSearch search_;          ///< from the last source
};

}  // namespace

std::optional<PieceForm> form_of(const CutPiece& piece, HollowSides hollow) {
    const int genus_and_borders = 2 - int(piece.borders.size()) - piece.euler;
    if (piece.has_apex) throw LayoutRefused{"a cone's tip is inside a face"};
    if (genus_and_borders != 0)
        throw LayoutRefused{fmt::format("a face has a handle ({} borders, Euler number {})",
                                        piece.borders.size(), piece.euler)};
    if (piece.borders.empty()) return PieceForm::Sphere;
    if (piece.borders.size() > 1 || has_reflex(piece)) return std::nullopt;
    const Border& border = piece.borders[0];
    if (hollow == HollowSides::AreCut && corner_count(border) > 1 && hollow_side(border))
        return std::nullopt;
    switch (corner_count(border)) {
        case 0: return PieceForm::Disc;
        case 1: return PieceForm::Drop;
        case 2: return PieceForm::Lens;
        case 3:
        case 5: return PieceForm::Polygon;
        case 4: return PieceForm::Block;
        default: return std::nullopt;
    }
}

Cut best_cut(const CutPiece& piece, const PieceMesh& mesh, Poll& poll) {
    return CutSearch(piece, mesh, poll).best();
}

}  // namespace patchwright::cage
