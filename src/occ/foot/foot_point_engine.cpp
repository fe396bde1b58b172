#include "occ/foot/foot_point_engine.h"

#include "occ/foot/faces_beside.h"
#include "occ/foot/fused.h"
#include "occ/foot/leaf_bounds.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

namespace patchwright::occ {

using geom::FootPoint;
using geom::Vec3;

namespace {

constexpr std::size_t max_known_feet = 16;

// One thread's working memory: kept so that queries allocate nothing once it has grown.
struct SearchScratch {
    std::vector<SeedCandidate> candidates;
    std::vector<PassedLeaf> passed;
    std::vector<SurfaceFoot> feet;
    std::vector<CurveHit> hits;
    std::vector<NormalBeside> beside;
    std::vector<Vec2> known;
};

SearchScratch& scratch() {
    thread_local SearchScratch memory;
    return memory;
}

struct Nearest {
    std::optional<SurfaceFoot> on_face;
    Vec3 point = Vec3::Zero();
    double distance = base::infinity;
};

class FootSearch {
  public:
    /// @param bound  something on the model is no farther
    FootSearch(const SearchModel& model, const Vec3& query, double bound)
        : model_(model),
          query_(query),
          s_(scratch()),
          first_bound_(bound + coincident * model.size) {
        s_.feet.clear();
    }

    FootPoint plain() { return has_fused_multiply_add ? plain_fused() : plain_any(); }

    FootPoint facing(const Vec3& side) {
        FootPoint answer = plain();
        if (turned_to(side, s_.beside, answer)) return answer;
        return facing_within(side, answer.distance + model_.side_reach).value_or(answer);
    }

    FootPoint on(const std::vector<char>& faces, const std::optional<Vec3>& side) {
        const auto nearest = nearest_on(faces, std::nullopt, base::infinity);
        if (!nearest) return side ? facing(*side) : plain();
        if (!side || nearest->normal.dot(*side) > 0.0) return *nearest;
        return nearest_on(faces, side, nearest->distance + model_.side_reach).value_or(*nearest);
    }

  private:
    PATCHWRIGHT_FUSED [[gnu::flatten]] FootPoint plain_fused() { return plain_any(); }

    FootPoint plain_any() {
        Nearest nearest = nearest_on_all();
        // What the spread of normals excludes must not matter; samples may have missed some.
        if (!(nearest.distance <= triangle_bound_ + coincident * model_.size)) {
            all_triangles_ = true;
            s_.feet.clear();
            nearest = nearest_on_all();
        }
        FootPoint answer;
        answer.point = nearest.point;
        answer.distance = nearest.distance;
        list_faces_beside(model_, answer, nearest.on_face ? &*nearest.on_face : nullptr, s_.hits,
                          s_.beside);
        choose_face(model_, query_, s_.beside, answer);
        return answer;
    }

    [[nodiscard]] const FaceSurface& surface(int face) const {
        return model_.surfaces[std::size_t(face)];
    }

    // Triangles that may hold the nearest point, nearest first, and a bound for its distance.
    double collect_candidates() {
        std::size_t count = 0;
        s_.passed.clear();
        const Mask all_triangles = Mask{} - int(all_triangles_);
        const double bound = visit_leaves(
            first_bound_, [&](int slot, const auto& near, const LeafBounds& leaf, double limit) {
                constexpr std::size_t lanes = geom::TriangleTree::lanes;
                limit = std::min(limit, double(leaf.least_upper()));
                const auto most = static_cast<float>(limit);
                s_.passed.emplace_back();
                store(leaf.lower, s_.passed.back().lower);
                s_.passed.back().slot = slot;
                if (s_.candidates.size() < count + lanes) s_.candidates.resize(2 * (count + lanes));
                const Mask counts = (leaf.lower <= most) & (leaf.may_hold_foot | all_triangles);
                count += write_candidates(leaf, near, slot, counts, s_.candidates.data() + count);
                return limit;
            });
        const auto begin = s_.candidates.begin();
        const auto end = std::remove_if(begin, begin + std::ptrdiff_t(count),
                                        [&](const SeedCandidate& c) { return c.lower > bound; });
        std::sort(begin, end, [](const SeedCandidate& a, const SeedCandidate& b) {
            return std::pair(a.lower, a.slot) < std::pair(b.lower, b.slot);
        });
        candidates_ = {s_.candidates.data(), std::size_t(end - begin)};
        return bound;
    }

    template <class Visit>
    double visit_leaves(double bound, Visit&& visit) const {
        const auto& tree = model_.mesh.tree;
        const auto extent = static_cast<float>(tree.slack(0.0) / tree.slack_rel);
        return tree.nearest(query_, bound, [&](int slot, int, const auto& near, double limit) {
            const SeedBlock& seeds =
                model_.mesh.seeds[std::size_t(slot) / geom::TriangleTree::lanes];
            return visit(slot, near, LeafBounds(near, seeds, extent), limit);
        });
    }

    // Descends from a triangle's nearest point and calls `found` with each new local minimum. Where
    // the surface curves more than a sphere around the query, one triangle may hold several.
    template <class Found>
    void descend(const SeedCandidate& c, Found&& found) {
        const SeedStart& t = model_.mesh.starts[std::size_t(c.slot)];
        const Vec2 start = start_of(c);
        descend_from(c.slot, start, found);
        const double above = double(t.bend[0]), below = double(t.bend[1]);
        const double bend = std::abs(c.height) <= c.distance - c.lower ? std::max(above, below)
                            : c.height > 0.0f                          ? above
                                                                       : below;
        if (double(c.distance) * bend < convex_share) return;
        constexpr double third = 1.0 / 3.0, far = 2.0 / 3.0, near = 1.0 / 6.0;
        for (const Vec3& w : {Vec3(third, third, third), Vec3(far, near, near),
                              Vec3(near, far, near), Vec3(near, near, far)})
            descend_from(c.slot, at(t, w), found);
        descend_in_spans(c.slot, start, found);
    }

    static Vec2 at(const SeedStart& t, const Vec3& w) {
        return w[0] * t.uv[0] + w[1] * t.uv[1] + w[2] * t.uv[2];
    }
    [[nodiscard]] Vec2 start_of(const SeedCandidate& c) const {
        return at(model_.mesh.starts[std::size_t(c.slot)],
                  model_.mesh.tree.weights_near(c.slot, query_));
    }

    // Spans much shorter than the triangle are missed by evenly spread starts: from the triangle's
    // nearest point go to the nearest end, the middle and the far end of each.
    template <class Found>
    void descend_in_spans(int slot, const Vec2& start, Found&& found) {
        constexpr double short_share = 0.25;
        const SeedStart& t = model_.mesh.starts[std::size_t(slot)];
        const FaceSurface::Rectangle box = box_of(t.uv);
        const Vec2 size = box.high - box.low;
        surface(t.face).each_span(box, [&](const FaceSurface::Rectangle& span) {
            const Vec2 extent = span.high - span.low;
            if ((extent.array() >= short_share * size.array()).all()) return;
            const Vec2 margin = 0.1 * extent, low = span.low + margin, high = span.high - margin;
            descend_from(slot, start.cwiseMax(low).cwiseMin(high), found);
            if ((extent.array() >= 0.5 * short_share * size.array()).all()) return;
            descend_from(slot, 0.5 * (low + high), found);
            descend_from(slot, (low + high - start).cwiseMax(low).cwiseMin(high), found);
        });
    }

    template <class Found>
    void descend_from(int slot, const Vec2& uv, Found&& found) {
        const SeedStart& t = model_.mesh.starts[std::size_t(slot)];
        s_.known.clear();
        for (const SurfaceFoot& f : s_.feet) {
            if (s_.known.size() == max_known_feet) break;
            if (f.face == t.face) s_.known.push_back(f.foot.uv);
        }
        const auto foot = surface(t.face).descend(query_, {uv, double(t.stride)}, s_.known);
        if (foot.merged) return;
        s_.feet.push_back({t.face, slot, foot});
        found(s_.feet.back());
    }

    Nearest nearest_on_all() {
        triangle_bound_ = collect_candidates();
        Nearest nearest = nearest_on_faces();
        if (clear_ > edge_bound_ + 2.0 * coincident * model_.size ||
            (nearest.on_face && is_alone(model_.mesh, query_, *nearest.on_face, s_.passed,
                                         nearest.distance + coincident * model_.size))) {
            s_.hits.clear();
            return nearest;
        }
        nearest_on_edges(nearest);
        descend_from_edges(nearest);
        return nearest;
    }

    // A foot that hugs an edge may lie in a triangle whose bounds, taken by samples, say that it
    // holds none: from a point on an edge go on into the faces beside it.
    void descend_from_edges(Nearest& nearest) {
        const double slack = coincident * model_.size;
        const Vec3 from = nearest.point;
        for (const CurveHit& hit : s_.hits) {
            if ((hit.point - from).squaredNorm() > slack * slack) continue;
            const ModelEdge& edge = model_.network.edges[std::size_t(hit.edge)];
            for (const FaceOfEdge& use : edge.uses) {
                const FaceSurface& face = surface(use.face);
                const FaceSurface::Start start{parameters_beside(edge, use, hit.t), hit.distance};
                const auto foot = face.descend(query_, start, {});
                if (foot.distance < nearest.distance - slack && face.contains(foot.uv))
                    nearest = {SurfaceFoot{use.face, -1, foot}, foot.point, foot.distance};
            }
        }
    }

    Nearest nearest_on_faces() {
        Nearest nearest;
        clear_ = 0.0;
        // A foot beyond the trim says that an edge may be nearest: what is farther off is passed.
        std::optional<double> to_edge;
        for (const SeedCandidate& c : candidates_) {
            if (c.lower > std::min(nearest.distance, to_edge.value_or(base::infinity))) break;
            if (nearest.on_face &&
                holds_none_nearer_than(model_.mesh, query_, *nearest.on_face, c.slot))
                continue;
            const double distance = c.distance;
            clear_ = std::max(clear_, double(around(c.slot).clearance) - distance -
                                          model_.mesh.tree.slack(distance));
            descend(c, [&](const SurfaceFoot& f) {
                if (!(f.foot.distance < nearest.distance)) return;
                if (is_on_model(f))
                    nearest = {f, f.foot.point, f.foot.distance};
                else if (!to_edge)
                    to_edge = distance_to_edges();
            });
        }
        edge_bound_ = std::min(nearest.distance, triangle_bound_);
        return nearest;
    }

    [[nodiscard]] const Surroundings& around(int slot) const {
        return model_.mesh.around[std::size_t(slot)];
    }

    [[nodiscard]] bool is_on_model(const SurfaceFoot& f) const {
        if (is_clear_of_trim(model_.mesh, f)) return true;
        return surface(f.face).contains(f.foot.uv);
    }

    void nearest_on_edges(Nearest& nearest) {
        const double slack = coincident * model_.size;
        collect_hits(edge_bound_ + slack);
        if (s_.hits.empty() && !nearest.on_face) collect_hits(base::infinity);
        for (const CurveHit& hit : s_.hits) {
            // A foot held by the end of its face is on an edge: that is the answer then, as whether
            // a descent happens to end there depends on the bound.
            const bool held = nearest.on_face && (nearest.on_face->foot.held[0] != 0 ||
                                                  nearest.on_face->foot.held[1] != 0);
            const double gain = held ? -slack : 1e-12 * model_.size;
            if (hit.distance >= nearest.distance - gain) continue;
            nearest = {std::nullopt, hit.point, hit.distance};
        }
        if (nearest.distance < base::infinity || candidates_.empty()) return;
        // A face without any edge and no foot in its trim: the triangulation is all there is.
        const SeedCandidate& c = candidates_.front();
        const int face = model_.mesh.starts[std::size_t(c.slot)].face;
        FaceSurface::Foot foot;
        foot.uv = start_of(c);
        foot.point = surface(face).at(foot.uv);
        foot.normal = surface(face).normal(foot.uv);
        foot.distance = (foot.point - query_).norm();
        nearest = {SurfaceFoot{face, c.slot, foot}, foot.point, foot.distance};
    }

    /// Of the nearest one, or that of the triangulation's bound where none is nearer.
    double distance_to_edges() {
        collect_hits(triangle_bound_);
        double least = triangle_bound_;
        for (const CurveHit& hit : s_.hits) least = std::min(least, hit.distance);
        return least + coincident * model_.size;
    }

    void collect_hits(double bound) {
        const double slack = coincident * model_.size;
        s_.hits.clear();
        model_.all_edges.visit(query_, bound, [&](const CurveHit& hit, double limit) {
            s_.hits.push_back(hit);
            return std::min(limit, hit.distance + slack);
        });
    }

    std::optional<FootPoint> facing_within(const Vec3& side, double reach) {
        return nearest_accepted(
            reach, {&model_.sharp_edges, &model_.free_edges},
            [&](int, const MeshTriangle& t) { return may_face(t, side); },
            [&](int, const Vec3& normal) { return normal.dot(side) > 0.0; });
    }

    std::optional<FootPoint> nearest_on(const std::vector<char>& faces,
                                        const std::optional<Vec3>& side, double reach) {
        return nearest_accepted(
            reach, {&model_.all_edges},
            [&](int face, const MeshTriangle& t) {
                return faces[std::size_t(face)] != 0 && (!side || may_face(t, *side));
            },
            [&](int face, const Vec3& normal) {
                return faces[std::size_t(face)] != 0 && (!side || normal.dot(*side) > 0.0);
            });
    }

    /// The nearest point within a reach of those that are accepted by their face and normal.
    template <class MayHold, class Accepts>
    std::optional<FootPoint> nearest_accepted(double reach,
                                              std::initializer_list<const CurveSearch*> edges,
                                              const MayHold& may_hold, const Accepts& accepts) {
        std::optional<FootPoint> best;
        const auto offer = [&](const SurfaceFoot& f) {
            // A foot held by the end of its face is no local minimum; edges have their turn.
            if (f.foot.distance > reach || f.foot.held[0] != 0 || f.foot.held[1] != 0) return;
            if (!surface(f.face).contains(f.foot.uv)) return;
            if (!accepts(f.face, f.foot.normal)) return;
            reach = f.foot.distance;
            best = FootPoint{f.foot.point, f.foot.normal, f.foot.distance, f.face, f.foot.uv};
        };
        for (const SurfaceFoot& f : s_.feet) offer(f);
        visit_leaves(reach, [&](int slot, const auto& near, const LeafBounds& leaf, double) {
            constexpr std::size_t lanes = geom::TriangleTree::lanes;
            const SeedBlock& seeds = model_.mesh.seeds[std::size_t(slot) / lanes];
            for (std::size_t i = 0; i < lanes; ++i) {
                if (double(leaf.lower[i]) > reach || leaf.may_hold_foot[i] == 0) continue;
                if (may_hold(model_.mesh.starts[std::size_t(slot) + i].face,
                             model_.mesh.triangles[std::size_t(seeds.triangle[i])]))
                    descend({leaf.lower[i], slot + int(i), near.distance[i], near.height[i]},
                            offer);
            }
            return reach;
        });
        const auto visit = [&](const CurveHit& hit, double limit) {
            if (hit.distance >= limit) return limit;
            s_.beside.clear();
            add_uses(model_, hit, s_.beside);
            for (const NormalBeside& f : s_.beside) {
                if (!accepts(f.face, f.normal)) continue;
                reach = hit.distance;
                best = FootPoint{hit.point, f.normal, hit.distance, f.face, f.uv};
                break;
            }
            return reach;
        };
        for (const CurveSearch* search : edges) search->visit(query_, reach, visit);
        return best;
    }

    const SearchModel& model_;
    Vec3 query_;
    SearchScratch& s_;
    double first_bound_;                      ///< something on the model is no farther
    double triangle_bound_ = base::infinity;  ///< the same, by the triangulation
    double edge_bound_ = base::infinity;
    double clear_ = 0.0;  ///< no edge is nearer
    std::span<const SeedCandidate> candidates_;
    bool all_triangles_ = false;
};

}  // namespace

FootPoint nearest_point(const SearchModel& model, const Vec3& query, double bound) {
    return FootSearch(model, query, bound).plain();
}

FootPoint nearest_point_facing(const SearchModel& model, const Vec3& query, const Vec3& side,
                               double bound) {
    return FootSearch(model, query, bound).facing(side);
}

FootPoint nearest_point_on(const SearchModel& model, const std::vector<char>& faces,
                           const Vec3& query, const std::optional<Vec3>& side) {
    return FootSearch(model, query, base::infinity).on(faces, side);
}

}  // namespace patchwright::occ
