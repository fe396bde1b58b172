#include "measure/surface_crossing.h"

#include "geom/bvh.h"
#include "measure/piece_meeting.h"

#include <patchwright/base/parallel.h>

#include <map>
#include <optional>

namespace patchwright::measure {

namespace {

/// Of the resolution: how near two points are that count as one.
constexpr double exact = 1e-6;
/// Between reports of progress, and of one thread at once.
constexpr std::size_t pieces_a_block = 1024, pieces_a_task = 8;

class Crossings {
  public:
    Crossings(const std::vector<geom::BsplineSurface>& surfaces,
              const std::vector<const BezierGrid*>& grids, double resolution)
        : surfaces_(surfaces), resolution_(resolution) {
        std::vector<geom::Box3> boxes;
        for (std::size_t s = 0; s < grids.size(); ++s) {
            for (const BezierPiece& piece : grids[s]->pieces) {
                items_.push_back({int(s), &piece});
                boxes.push_back(piece.box);
            }
        }
        if (!boxes.empty()) tree_ = geom::Bvh(boxes);
    }

    [[nodiscard]] std::size_t count() const { return items_.size(); }

    /// Of a piece with those of later surfaces: the first of each surface that it crosses.
    [[nodiscard]] std::vector<SelfIntersection> of_piece(std::size_t number) const {
        std::vector<SelfIntersection> hits;
        const auto [surface, piece] = items_[number];
        std::vector<int> near;
        tree_.nearest(piece->box.centre(), 0.5 * piece->size(), [&](int other, double bound) {
            if (items_[std::size_t(other)].surface > surface) near.push_back(other);
            return bound;
        });
        std::sort(near.begin(), near.end());
        for (const int other : near) {
            const Item& item = items_[std::size_t(other)];
            if (!hits.empty() && hits.back().surfaces[1] == item.surface) continue;
            if (auto hit = search(surface, *piece, item.surface, *item.piece)) hits.push_back(*hit);
        }
        return hits;
    }

  private:
    struct Item {
        int surface;
        const BezierPiece* piece;
    };

    [[nodiscard]] std::optional<SelfIntersection> search(int s, const BezierPiece& a, int t,
                                                         const BezierPiece& b) const {
        if ((a.box.min.array() > b.box.max.array()).any() ||
            (b.box.min.array() > a.box.max.array()).any() || are_apart(a, b, resolution_))
            return std::nullopt;
        const auto met = meeting_point(a, b, exact * resolution_);
        if (met &&
            !(is_beside_side(surfaces_[std::size_t(s)], met->point, met->uv[0], resolution_) &&
              is_beside_side(surfaces_[std::size_t(t)], met->point, met->uv[1], resolution_)))
            return SelfIntersection{{s, t}, met->point, met->uv};
        if (a.size() <= resolution_ && b.size() <= resolution_) return std::nullopt;
        const bool split_a = a.size() >= b.size();
        for (const BezierPiece& part : (split_a ? a : b).halves(exact * resolution_)) {
            if (auto hit = split_a ? search(s, part, t, b) : search(s, a, t, part)) return hit;
        }
        return std::nullopt;
    }

    const std::vector<geom::BsplineSurface>& surfaces_;
    double resolution_;
    std::vector<Item> items_;
    geom::Bvh tree_;
};

}  // namespace

std::vector<SelfIntersection> find_crossings(const std::vector<geom::BsplineSurface>& surfaces,
                                             const std::vector<const BezierGrid*>& grids,
                                             double resolution_mm, const base::Progress& progress) {
    const Crossings crossings(surfaces, grids, resolution_mm);
    std::vector<std::vector<SelfIntersection>> found(crossings.count());
    for (std::size_t start = 0; start < found.size(); start += pieces_a_block) {
        base::report_progress(progress, "crossings", double(start) / double(found.size()));
        base::parallel_for(std::min(pieces_a_block, found.size() - start), pieces_a_task,
                           [&](std::size_t begin, std::size_t end) {
                               for (std::size_t k = start + begin; k < start + end; ++k)
                                   found[k] = crossings.of_piece(k);
                           });
    }
    std::map<std::array<int, 2>, SelfIntersection> first;
    for (const auto& hits : found)
        for (const SelfIntersection& hit : hits) first.try_emplace(hit.surfaces, hit);
    std::vector<SelfIntersection> result;
    for (const auto& [pair, hit] : first) result.push_back(hit);
    return result;
}

}  // namespace patchwright::measure
