#include "cage/blocks/brep_layout.h"

#include "cage/blocks/cuts.h"
#include "cage/blocks/piece_blocks.h"

#include <patchwright/base/numbers.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Cuts by piece that the model's features bound, and the fewest: more come from cuts that help
// nothing.
constexpr int cuts_per_piece = 30, fewest_cuts = 30;
// Between two splits of a side: how far a split may be from its place, and how much farther it may
// be to fall on a node that is there already.
constexpr double split_window = 0.45, split_to_node = 0.3;
// The turn of a border, 34 degrees, from which on a node is a corner to begin a disc's blocks with.
constexpr double least_bend_rad = 0.6;
// Times that the edges of a side are halved for room.
constexpr int split_rounds = 6;

/// A piece that needs no more cuts.
struct Part {
    int seed = -1;  ///< a triangle
    PieceForm form = PieceForm::Block;
    std::vector<int> splits;  ///< vertices where its sides are parted, in order
};

class Builder {
  public:
    Builder(geom::EditableMesh& mesh, const geom::ModelSurface& reference, Poll& poll,
            const FieldLines* lines)
        : mesh_(mesh),
          reference_(reference),
          poll_(poll),
          pieces_(mesh, reference),
          lined_(lines != nullptr) {
        if (lines != nullptr) pieces_.add_lines(*lines);
    }

    QuadLayout build() {
        cut_up();
        for (Part& part : parts_) split_sides(part);
        if (!lined_) pieces_.smooth_cuts(poll_);
        for (const Part& part : parts_) add_blocks(part);
        return std::move(layout_);
    }

  private:
    /// A piece by one triangle; it need not be made again if it is at hand.
    struct Pending {
        int seed;
        std::optional<CutPiece> piece;
    };

    /// What is pending then is what lies on either side of its beginning, which may be one piece.
    void make(const Cut& cut, const CutPiece& piece, std::vector<Pending>& pending) {
        const int a = piece.vertices[at(cut.path[0])], b = piece.vertices[at(cut.path[1])];
        pieces_.cut(piece, cut.path, cut.start, cut.end);
        pending.push_back({mesh_.sides(a, b).triangle[0], {}});
        CutPiece one = pieces_.piece(pending.back().seed);
        // Splits of bridges may have put other triangles next to the path.
        for (const int t : mesh_.sides(a, b).triangle) {
            if (std::binary_search(one.triangles.begin(), one.triangles.end(), t)) continue;
            pending.push_back({t, {}});
            return;
        }
        if (one.is_final) pending.back().piece = std::move(one);
    }

    void cut_up() {
        std::vector<Pending> pending;
        for (const int seed : pieces_.seeds()) pending.push_back({seed, {}});
        const int most_cuts = cuts_per_piece * int(pending.size()) + fewest_cuts;
        int cuts = 0;
        while (!pending.empty()) {
            poll_();
            Pending next = std::move(pending.back());
            pending.pop_back();
            const CutPiece piece = next.piece ? std::move(*next.piece) : pieces_.piece(next.seed);
            const auto form = form_of(piece, lined_ ? HollowSides::Stay : HollowSides::AreCut);
            if (form) {
                parts_.push_back({next.seed, *form, {}});
                continue;
            }
            if (++cuts > most_cuts) throw LayoutRefused{"faces need too many cuts"};
            make(best_cut(piece, pieces_, poll_), piece, pending);
        }
    }

    // Parting of sides.

    struct BorderRun {
        int first, count;  ///< border points of a side, its first corner but not the next one
    };

    [[nodiscard]] static std::vector<BorderRun> runs_of(const Border& border) {
        std::vector<BorderRun> runs;
        const int n = int(border.size());
        const int start = first_corner(border);
        if (start < 0) {
            const auto node = std::find_if(border.begin(), border.end(),
                                           [](const BorderPoint& p) { return p.node; });
            return {{node == border.end() ? 0 : int(node - border.begin()), n}};
        }
        for (int k = 0; k < n; ++k) {
            if (border[at((start + k) % n)].faces == 1) runs.push_back({(start + k) % n, 0});
            ++runs.back().count;
        }
        return runs;
    }

    /// Lengths from border point `first` to itself and each of the `count` that follow.
    [[nodiscard]] std::vector<double> lengths_along(const Border& border, int first,
                                                    int count) const {
        std::vector<double> length{0.0};
        for (int k = 0; k < count; ++k) {
            const BorderPoint& p = border[at((first + k) % int(border.size()))];
            length.push_back(length.back() + (mesh_.point(p.vertex) - mesh_.point(p.next)).norm());
        }
        return length;
    }

    /// The vertex nearest to a share of a side's length, better one that is a node; -1: none
    /// inside.
    [[nodiscard]] int vertex_at(const Border& border, const BorderRun& run, double share,
                                double spacing) const {
        const int n = int(border.size());
        const std::vector<double> length = lengths_along(border, run.first, run.count);
        int best = -1;
        double least = std::numeric_limits<double>::infinity();
        for (int k = 1; k < run.count; ++k) {
            const int v = border[at((run.first + k) % n)].vertex;
            const double off = std::abs(length[at(k)] / length.back() - share);
            const double cost = off - (pieces_.is_node(v) ? split_to_node * spacing : 0.0);
            if (off > split_window * spacing || cost >= least) continue;
            least = cost;
            best = v;
        }
        return best;
    }

    /// The vertices of the four nodes where a border bends most, when there are just four.
    [[nodiscard]] static std::vector<int> four_bends(const Border& border) {
        std::vector<int> result;
        for (const BorderPoint& p : border)
            if (p.node && M_PI - p.angle > least_bend_rad) result.push_back(p.vertex);
        if (result.size() != 4) result.clear();
        return result;
    }

    void split_sides(Part& part) {
        const int sections = part.form == PieceForm::Polygon ? 2
                             : part.form == PieceForm::Lens  ? 3
                             : part.form == PieceForm::Disc  ? 4
                             : part.form == PieceForm::Drop  ? 5
                                                             : 1;
        if (part.form == PieceForm::Sphere) throw LayoutRefused{"a face is closed in itself"};
        for (int round = 0; round < split_rounds; ++round) {
            poll_();
            const CutPiece piece = pieces_.piece(part.seed);
            const Border& border = piece.borders[0];
            part.splits = part.form == PieceForm::Disc ? four_bends(border) : std::vector<int>();
            if (!part.splits.empty()) return;
            bool enough = true;
            for (const BorderRun& run : runs_of(border)) {
                // A border without corners begins at a node, or anywhere.
                if (part.form == PieceForm::Disc)
                    part.splits.push_back(border[at(run.first)].vertex);
                for (int k = 1; k < sections && enough; ++k) {
                    const int v = vertex_at(border, run, double(k) / sections, 1.0 / sections);
                    enough = v >= 0 && (part.splits.empty() || part.splits.back() != v);
                    part.splits.push_back(v);
                }
                if (!enough) {
                    const int n = int(border.size());
                    for (int k = 0; k < run.count; ++k) {
                        const BorderPoint& p = border[at((run.first + k) % n)];
                        pieces_.split_wall(p.vertex, p.next);
                    }
                    break;
                }
            }
            if (!enough) continue;
            for (const int v : part.splits) pieces_.make_node(v);
            return;
        }
        throw LayoutRefused{"a side is too short to be parted"};
    }

    // Arcs.

    int node_of(int vertex) {
        const auto [it, added] = nodes_.emplace(vertex, int(layout_.nodes.size()));
        if (added) {
            LayoutNode node;
            node.point = mesh_.point(vertex);
            int hard = 0, sides = 0;
            std::set<int> curves;
            bool held = mesh_.is_boundary(vertex);
            for (const int w : mesh_.feature_neighbours(vertex)) {
                const geom::EdgeSides s = mesh_.sides(vertex, w);
                const int curve = mesh_.curve(s.triangle[0], s.side[0]);
                const auto kind = reference_.features().curves[at(curve)].kind;
                hard += kind != geom::FeatureKind::Smooth ? 1 : 0;
                held = true;
                curves.insert(curve);
                ++sides;
            }
            node.held = held;
            if (curves.size() == 1 && sides == 2 && mesh_.corner(vertex) < 0)
                node.curve = *curves.begin();
            // A crease may end in a smooth surface; three and more make a corner by themselves.
            node.corner = mesh_.corner(vertex) >= 0 && hard != 1;
            layout_.nodes.push_back(node);
        }
        return it->second;
    }

    ArcUse arc_from(int vertex, int next) {
        const auto known = arcs_.find({vertex, next});
        if (known != arcs_.end()) return known->second;
        LayoutArc arc;
        arc.start = node_of(vertex);
        const geom::EdgeSides s = mesh_.sides(vertex, next);
        arc.curve = mesh_.curve(s.triangle[0], s.side[0]);
        arc.crease = arc.curve >= 0 && s.triangle[1] >= 0 &&
                     reference_.features().curves[at(arc.curve)].kind == geom::FeatureKind::Sharp;
        arc.points.push_back(mesh_.point(vertex));
        int last = vertex, here = next;
        while (!pieces_.is_node(here)) {
            arc.points.push_back(mesh_.point(here));
            int onward = -1;
            for (const int w : mesh_.neighbours(here))
                if (w != last && pieces_.is_wall(here, w)) onward = w;
            if (onward < 0) throw LayoutRefused{"a line ends inside a face"};
            last = here;
            here = onward;
        }
        arc.points.push_back(mesh_.point(here));
        arc.end = node_of(here);
        const int number = int(layout_.arcs.size());
        arcs_[{vertex, next}] = {number, false};
        arcs_[{here, last}] = {number, true};
        layout_.arcs.push_back(std::move(arc));
        return {number, false};
    }

    // Pieces to blocks.

    /// Where corners and splits are on a border, in its order.
    [[nodiscard]] static std::vector<int> stops_of(const Border& border, const Part& part) {
        std::vector<int> stops;
        const int n = int(border.size());
        // Discs have no corners; they begin at their first split.
        const auto first = std::find_if(border.begin(), border.end(), [&](const BorderPoint& p) {
            return !part.splits.empty() && p.vertex == part.splits[0];
        });
        const int start =
            part.form == PieceForm::Disc ? int(first - border.begin()) : first_corner(border);
        std::size_t next = 0;
        for (int k = 0; k < n; ++k) {
            const int i = (start + k) % n;
            const bool corner = border[at(i)].faces == 1;
            const bool split =
                !corner && next < part.splits.size() && border[at(i)].vertex == part.splits[next];
            if (split) ++next;
            if (corner || split) stops.push_back(i);
        }
        if (next != part.splits.size()) throw LayoutRefused{"a side was parted out of order"};
        return stops;
    }

    /// Where the stops go: corners of a regular polygon, or of polygons also the middles of sides.
    [[nodiscard]] static std::vector<Vec2> polygon_of(const Part& part, int stops) {
        const bool middles = part.form == PieceForm::Polygon;
        const int n = middles ? stops / 2 : stops;
        const auto corner = [&](int k) {
            const double angle = 2.0 * M_PI * k / n;
            return Vec2(std::cos(angle), std::sin(angle));
        };
        std::vector<Vec2> result;
        for (int k = 0; k < n; ++k) {
            result.push_back(corner(k));
            if (middles) result.push_back(0.5 * (corner(k) + corner(k + 1)));
        }
        return result;
    }

    void add_blocks(const Part& part) {
        const CutPiece piece = pieces_.piece(part.seed);
        const Border& border = piece.borders[0];
        const std::vector<int> stops = stops_of(border, part);
        const std::vector<Vec2> polygon = polygon_of(part, int(stops.size()));
        const int n = int(border.size()), count = int(stops.size());
        std::vector<Vec2> flat(border.size());
        FlatBorder around;
        for (int s = 0; s < count; ++s) {
            const int first = stops[at(s)], last = stops[at((s + 1) % count)];
            const std::vector<double> length =
                lengths_along(border, first, first == last ? n : (last - first + n) % n);
            FlatSide side;
            side.end = polygon[at((s + 1) % count)];
            for (std::size_t i = 0; i + 1 < length.size(); ++i) {
                const int k = (first + int(i)) % n;
                flat[at(k)] = polygon[at(s)] + (side.end - polygon[at(s)]) *
                                                   (length[i] / std::max(length.back(), 1e-300));
                if (!pieces_.is_node(border[at(k)].vertex)) continue;
                side.arcs.push_back(arc_from(border[at(k)].vertex, border[at(k)].next));
                side.flat.push_back(flat[at(k)]);
            }
            around.sides.push_back(std::move(side));
            around.nodes.push_back(node_of(border[at(first)].vertex));
        }
        std::vector<Vec3> points;
        for (const int v : piece.vertices) points.push_back(mesh_.point(v));
        layout_.pieces.emplace_back(std::move(points), piece.corners, std::move(flat));
        around.polygon = polygon;
        add_piece_blocks(layout_, reference_, part.form, around);
        if (part.form == PieceForm::Block) layout_.blocks.back().first_point = stops[0];
    }

    geom::EditableMesh& mesh_;
    const geom::ModelSurface& reference_;
    Poll& poll_;
    PieceMesh pieces_;
    bool lined_;
    std::vector<Part> parts_;
    std::map<int, int> nodes_;
    std::map<std::pair<int, int>, ArcUse> arcs_;
    QuadLayout layout_;
};

}  // namespace

QuadLayout brep_layout(geom::EditableMesh& mesh, const geom::ModelSurface& reference, Poll& poll,
                       const FieldLines* lines) {
    return Builder(mesh, reference, poll, lines).build();
}

}  // namespace patchwright::cage
