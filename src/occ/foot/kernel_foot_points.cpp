#include "occ/foot/faces_beside.h"

#include <patchwright/base/error.h>
#include <patchwright/base/numbers.h>

#include <fmt/format.h>

#include <cmath>

namespace patchwright::occ {

namespace {

using geom::FootPoint;
using geom::Vec3;

// Of the model's size: an edge is no nearer than a face by less than this.
constexpr double edge_gain = 1e-12;

/// What the kernel has found around a query.
struct KernelNearest {
    std::vector<SurfaceFoot> feet;
    std::vector<CurveHit> hits;
    std::vector<NormalBeside> beside;
    FootPoint answer;

    /// @param beyond  how much farther than the nearest one others are looked for
    KernelNearest(const SearchModel& model, const Vec3& query, double beyond) {
        model.kernel->find(query, beyond + coincident * model.size, feet, hits);
        const SurfaceFoot* on_face = nullptr;
        answer.distance = base::infinity;
        for (const SurfaceFoot& f : feet) {
            if (f.foot.distance >= answer.distance) continue;
            on_face = &f;
            answer.point = f.foot.point;
            answer.distance = f.foot.distance;
        }
        for (const CurveHit& hit : hits) {
            // As in the search: a foot at the end of its face is on an edge.
            const double gain = on_face != nullptr && is_held(*on_face) ? -coincident : edge_gain;
            if (hit.distance >= answer.distance - gain * model.size) continue;
            on_face = nullptr;
            answer.point = hit.point;
            answer.distance = hit.distance;
        }
        if (!std::isfinite(answer.distance))
            throw base::InputError(fmt::format("the CAD kernel finds no foot point of ({}, {}, {})",
                                               query.x(), query.y(), query.z()));
        list_faces_beside(model, answer, on_face, hits, beside);
        choose_face(model, query, beside, answer);
    }
};

}  // namespace

FootPoint nearest_point_by_kernel(const SearchModel& model, const Vec3& query) {
    return KernelNearest(model, query, 0.0).answer;
}

FootPoint nearest_point_facing_by_kernel(const SearchModel& model, const Vec3& query,
                                         const Vec3& side) {
    KernelNearest plain(model, query, 0.0);
    if (turned_to(side, plain.beside, plain.answer)) return plain.answer;
    KernelNearest found(model, query, model.side_reach);
    FootPoint best = found.answer;
    double reach = found.answer.distance + model.side_reach;
    const auto offer = [&](const Vec3& point, double distance, const NormalBeside& f) {
        if (distance > reach || !(f.normal.dot(side) > 0.0)) return;
        reach = distance;
        best = {point, f.normal, distance, f.face, f.uv};
    };
    for (const SurfaceFoot& f : found.feet)
        if (!is_held(f)) offer(f.foot.point, f.foot.distance, {f.face, f.foot.normal, f.foot.uv});
    for (const CurveHit& hit : found.hits) {
        if (model.network.edges[std::size_t(hit.edge)].kind == EdgeKind::Smooth) continue;
        found.beside.clear();
        add_uses(model, hit, found.beside);
        for (const NormalBeside& f : found.beside) offer(hit.point, hit.distance, f);
    }
    return best;
}

}  // namespace patchwright::occ
