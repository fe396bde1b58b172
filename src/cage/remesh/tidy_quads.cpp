#include "cage/remesh/tidy_quads.h"

#include "cage/remesh/quad_shape.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>

namespace patchwright::cage {

namespace {

// Quads that are made are at least this good, or as good as the worst one they take the place of:
// vertices are relaxed afterwards.
constexpr double least_made_quality = 0.25;

// Of the angle to neighbours, 60 degrees, or as it was: around a thin nose two quads of the best
// shape may lie upon each other.
constexpr double least_made_cosine = 0.5;
// Of the edges of a quad, or as it was: the size field lets lengths grow by about 2 across a quad.
constexpr double least_made_ratio = 0.3;
// What a quad that has to be split counts as: its triangles have a vertex of valence 3 each.
constexpr int bad_quad = 4;

// Irregularity that one operation has to take away, in the order of the passes: what helps most is
// done first.
constexpr std::array<int, 4> gains{8, 4, 2, 1};
// Irregularity that the first of two operations may add: the second one has to take away more.
constexpr int most_added = 4;

class QuadTidying {
  public:
    QuadTidying(PolygonMesh& polygons, Poll& poll) : polygons_(polygons), poll_(poll) {}

    bool run() {
        bool any = false;
        for (const int least : gains)
            any = for_all([&](int polygon) { return improve_at_once({polygon}, 0, least); }) || any;
        return for_all([&](int polygon) { return improve_by_two(polygon); }) || any;
    }

  private:
    template <class Improve>
    bool for_all(const Improve& improve) {
        bool any = false;
        for (int polygon = 0; polygon < polygons_.count(); ++polygon) {
            poll_();
            while (is_irregular(polygon) && improve(polygon)) {
                changes_.clear();
                moves_.clear();
                any = true;
            }
        }
        return any;
    }

    [[nodiscard]] bool is_irregular(int polygon) const {
        const auto& c = polygons_.corners(polygon);
        return (c.size() == 4 && polygons_.quality(polygon) < least_quad_quality) ||
               std::any_of(c.begin(), c.end(),
                           [&](int v) { return polygons_.irregularity(v) > 0; });
    }

    struct Change {
        int polygon;
        std::vector<int> corners;  ///< before
    };
    struct Move {
        int vertex;
        geom::Vec3 point;  ///< before
    };

    struct Operation {
        int polygon, number;
    };

    /// All operations at some polygons: on the edges, twice each, and on the diagonals.
    [[nodiscard]] std::vector<Operation> operations(const std::set<int>& polygons) const {
        std::vector<Operation> result;
        for (const int polygon : polygons)
            if (polygons_.corners(polygon).size() == 4)
                for (int number = 0; number < 12; ++number) result.push_back({polygon, number});
        return result;
    }

    /// The best one of one operation each.
    /// @param gained  by the operations before: how much irregularity they took away
    /// @param least   with this one
    bool improve_at_once(const std::set<int>& at, int gained, int least) {
        int best = least - 1;
        std::optional<Operation> taken;
        for (const Operation& operation : operations(at)) {
            const std::size_t changes = changes_.size(), moves = moves_.size();
            int here = gained;
            least_gained_ = best + 1;
            if (apply(operation, here)) {
                best = here;
                taken = operation;
            }
            undo(changes, moves);
        }
        least_gained_ = best;
        return taken && apply(*taken, gained);
    }

    /// The first one of two operations, one after the other, that helps.
    bool improve_by_two(int polygon) {
        for (const Operation& operation : operations({polygon})) {
            int gained = 0;
            least_gained_ = -most_added;
            if (apply(operation, gained) && improve_at_once(around(), gained, 1)) return true;
            undo(0, 0);
        }
        return false;
    }

    [[nodiscard]] std::set<int> around() const {
        std::set<int> found;
        for (const Change& change : changes_)
            for (const int v : polygons_.corners(change.polygon))
                found.insert(polygons_.at_vertex(v).begin(), polygons_.at_vertex(v).end());
        return found;
    }

    bool apply(const Operation& operation, int& gained) {
        const int n = operation.number;
        return n < 8 ? turn(operation.polygon, std::size_t(n / 2), 1 + n % 2, gained)
                     : collapse(operation.polygon, std::size_t(n - 8), gained);
    }

    void change(int polygon, std::vector<int> corners) {
        changes_.push_back({polygon, polygons_.corners(polygon)});
        polygons_.replace(polygon, std::move(corners));
    }

    void undo(std::size_t changes, std::size_t moves) {
        for (; changes_.size() > changes; changes_.pop_back())
            polygons_.replace(changes_.back().polygon, std::move(changes_.back().corners));
        for (; moves_.size() > moves; moves_.pop_back())
            polygons_.move(moves_.back().vertex, moves_.back().point);
    }

    /// What must be as good after an operation as before.
    struct State {
        int irregularity = 0;
        double worst = 1.0;
        double cosine = 1.0;                     ///< to the neighbours of a quad, the least
        double ratio = 1.0;                      ///< of the edges of a quad, the least
        std::vector<std::pair<int, int>> flaws;  ///< by vertex
    };
    [[nodiscard]] State state(const std::set<int>& vertices, const std::set<int>& quads) const {
        State result;
        for (const int v : vertices) {
            if (polygons_.at_vertex(v).empty()) continue;
            result.irregularity += polygons_.irregularity(v);
            result.flaws.emplace_back(v, polygons_.flaws(v));
        }
        for (const int q : quads) {
            if (polygons_.corners(q).empty()) continue;
            const double quality = polygons_.quality(q);
            result.worst = std::min(result.worst, quality);
            result.ratio = std::min(result.ratio, polygons_.edge_ratio(q));
            result.cosine = std::min(result.cosine, polygons_.cosine_to_neighbours(q));
            if (quality < least_quad_quality) result.irregularity += bad_quad;
        }
        return result;
    }

    /// Whether the polygons that were changed are fine; adds what was gained.
    bool holds(const State& before, const std::set<int>& vertices, const std::set<int>& quads,
               int& gained) const {
        const State after = state(vertices, quads);
        gained += before.irregularity - after.irregularity;
        return gained >= least_gained_ &&
               after.worst >= std::min(before.worst, least_made_quality) &&
               after.cosine >= std::min(before.cosine, least_made_cosine) &&
               after.ratio >= std::min(before.ratio, least_made_ratio) &&
               std::all_of(before.flaws.begin(), before.flaws.end(),
                           [&](const auto& one) {
                               return polygons_.at_vertex(one.first).empty() ||
                                      polygons_.flaws(one.first) <= one.second;
                           }) &&
               std::all_of(quads.begin(), quads.end(), [&](int q) {
                   return polygons_.corners(q).empty() || polygons_.shares_edges_only(q);
               });
    }

    /// What is gained at most where a vertex gets so many faces more; exactly, inside surfaces.
    [[nodiscard]] int most_gained(int v, int faces) const {
        const int now = polygons_.irregularity(v);
        if (polygons_.kind(v) != geom::VertexKind::Smooth || polygons_.is_boundary(v)) return now;
        const int off = int(polygons_.at_vertex(v).size()) + faces - 4;
        return now - off * off;
    }

    /// Whether too little is gained even if all bad ones of these quads go.
    [[nodiscard]] bool gains_too_little(int gained, const std::set<int>& quads) const {
        if (gained + bad_quad * int(quads.size()) < least_gained_) return true;
        if (gained >= least_gained_) return false;
        for (const int q : quads)
            if (polygons_.quality(q) < least_quad_quality) gained += bad_quad;
        return gained < least_gained_;
    }

    /// Turns the edge from corner k on by one or two corners of the hexagon around it.
    bool turn(int polygon, std::size_t k, int by, int& gained) {
        const std::vector<int> c = polygons_.corners(polygon);
        const int a = c[k], b = c[(k + 1) % 4];
        if (polygons_.is_feature(a, b) || polygons_.of_edge(a, b).size() != 2) return false;
        const auto& two = polygons_.of_edge(a, b);
        const int other = two[0] == polygon ? two[1] : two[0];
        const std::vector<int> d = polygons_.corners(other);
        if (d.size() != 4) return false;
        const std::size_t j = std::size_t(std::find(d.begin(), d.end(), a) - d.begin());
        const std::array<int, 6> hexagon{b, c[(k + 2) % 4], c[(k + 3) % 4],
                                         a, d[(j + 1) % 4], d[(j + 2) % 4]};
        const std::set<int> vertices(hexagon.begin(), hexagon.end());
        if (vertices.size() != 6) return false;
        const auto at = [&](int i) { return hexagon[std::size_t((i + by) % 6)]; };
        if (!polygons_.of_edge(at(0), at(3)).empty()) return false;
        const std::set<int> quads{polygon, other};
        if (gains_too_little(gained + most_gained(a, -1) + most_gained(b, -1) +
                                 most_gained(at(0), 1) + most_gained(at(3), 1),
                             quads))
            return false;
        const State before = state(vertices, quads);
        change(polygon, {at(0), at(1), at(2), at(3)});
        change(other, {at(3), at(4), at(5), at(0)});
        return holds(before, vertices, quads, gained);
    }

    /// Merges corner k into the opposite one.
    bool collapse(int polygon, std::size_t k, int& gained) {
        const std::vector<int> c = polygons_.corners(polygon);
        const int gone = c[k], kept = c[(k + 2) % 4];
        const geom::EditableMesh& mesh = polygons_.mesh();
        if (polygons_.kind(gone) != geom::VertexKind::Smooth || polygons_.is_boundary(gone))
            return false;
        std::set<int> quads, vertices;
        for (const int v : {gone, kept})
            quads.insert(polygons_.at_vertex(v).begin(), polygons_.at_vertex(v).end());
        const int more = int(polygons_.at_vertex(gone).size()) - 2;
        if (gains_too_little(gained + polygons_.irregularity(gone) + most_gained(kept, more) +
                                 most_gained(c[(k + 1) % 4], -1) + most_gained(c[(k + 3) % 4], -1),
                             quads))
            return false;
        for (const int q : quads)
            vertices.insert(polygons_.corners(q).begin(), polygons_.corners(q).end());
        const State before = state(vertices, quads);
        const std::vector<int> fan = polygons_.at_vertex(gone);
        change(polygon, {});
        for (const int q : fan) {
            if (q == polygon) continue;
            std::vector<int> corners = polygons_.corners(q);
            if (std::find(corners.begin(), corners.end(), kept) != corners.end()) return false;
            std::replace(corners.begin(), corners.end(), gone, kept);
            change(q, std::move(corners));
        }
        if (polygons_.kind(kept) == geom::VertexKind::Smooth) {
            moves_.push_back({kept, mesh.point(kept)});
            polygons_.move(kept, 0.5 * (mesh.point(gone) + mesh.point(kept)));
        }
        return holds(before, vertices, quads, gained);
    }

    PolygonMesh& polygons_;
    Poll& poll_;
    int least_gained_ = 1;  ///< by the operations so far, so that they are kept
    std::vector<Change> changes_;
    std::vector<Move> moves_;
};

}  // namespace

bool tidy_quads(PolygonMesh& polygons, Poll& poll) { return QuadTidying(polygons, poll).run(); }

}  // namespace patchwright::cage
