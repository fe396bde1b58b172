// The faces around a nearest point, and which of them answers for it.
#pragma once

#include "occ/foot/beside_foot.h"
#include "occ/foot/foot_point_engine.h"

#include <cmath>
#include <vector>

namespace patchwright::occ {

// Of the model's size: points nearer to each other than this are one.
constexpr double coincident = 1e-9;

struct NormalBeside {
    int face;
    geom::Vec3 normal;
    Vec2 uv;
};

inline void add_uses(const SearchModel& model, const CurveHit& hit,
                     std::vector<NormalBeside>& beside) {
    const ModelEdge& edge = model.network.edges[std::size_t(hit.edge)];
    for (const FaceOfEdge& use : edge.uses)
        beside.push_back({use.face, normal_beside(edge, use, hit.t, model.surfaces),
                          parameters_beside(edge, use, hit.t)});
}

/// @param answer   with its point and distance
/// @param on_face  the foot that it is; null: it is on an edge
inline void list_faces_beside(const SearchModel& model, const geom::FootPoint& answer,
                              const SurfaceFoot* on_face, const std::vector<CurveHit>& hits,
                              std::vector<NormalBeside>& beside) {
    beside.clear();
    if (on_face != nullptr)
        beside.push_back({on_face->face, on_face->foot.normal, on_face->foot.uv});
    for (const CurveHit& hit : hits) {
        const ModelEdge& edge = model.network.edges[std::size_t(hit.edge)];
        const double slack = coincident * model.size, reach = 2.0 * edge.tolerance + slack;
        // Farther ones are met or not, as the bound has it.
        if (hit.distance > answer.distance + edge.tolerance + 0.5 * slack) continue;
        if ((hit.point - answer.point).norm() <= reach) add_uses(model, hit, beside);
    }
}

// Where faces meet at an angle, the one that looks most towards or away from the query tells the
// inside from the outside.
inline void choose_face(const SearchModel& model, const geom::Vec3& query,
                        const std::vector<NormalBeside>& beside, geom::FootPoint& answer) {
    const geom::Vec3 direction = answer.distance > coincident * model.size
                                     ? geom::Vec3((query - answer.point) / answer.distance)
                                     : geom::Vec3(geom::Vec3::Zero());
    double best = -1.0;
    for (const NormalBeside& f : beside) {
        const double looks = std::abs(f.normal.dot(direction));
        if (looks <= best + 1e-6) continue;
        best = looks;
        answer.face = f.face;
        answer.normal = f.normal;
        answer.uv = f.uv;
    }
}

/// Whether the answer faces the side, or has no normal, or a face beside it does, which then
/// answers.
inline bool turned_to(const geom::Vec3& side, const std::vector<NormalBeside>& beside,
                      geom::FootPoint& answer) {
    if (answer.normal.dot(side) > 0.0 || answer.normal.isZero(0.0)) return true;
    const NormalBeside* best = nullptr;
    for (const NormalBeside& f : beside) {
        if (f.normal.dot(side) > (best != nullptr ? best->normal.dot(side) : 0.0)) best = &f;
    }
    if (best == nullptr) return false;
    answer.face = best->face;
    answer.normal = best->normal;
    answer.uv = best->uv;
    return true;
}

}  // namespace patchwright::occ
