#include "fit/loop/vertex_targets.h"

#include "fit/loop/projection.h"

#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_mask.h>

#include <limits>
#include <map>

namespace patchwright::fit {

namespace {

using geom::Points;
using mesh::VertexId;

constexpr std::size_t vertices_a_task = 16;

/// Of vertices inside chains that follow a feature.
std::map<VertexId, const FeaturePath*> paths_of_vertices(const LevelFit& matched) {
    std::map<VertexId, const FeaturePath*> paths;
    for (std::size_t i = 0; i < matched.match.paths.size(); ++i) {
        if (matched.match.paths[i].empty()) continue;
        for (const VertexId v : matched.curves.chains[i].vertices)
            paths.try_emplace(v, &matched.match.paths[i]);
    }
    return paths;
}

}  // namespace

Points vertex_targets(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                      const LevelFit& matched) {
    const mesh::Topology& t = *cage.topology;
    const std::map<VertexId, const FeaturePath*> paths = paths_of_vertices(matched);
    const subd::LimitEvaluator limit(cage.topology);
    Points targets(t.vertex_count(), 3);
    base::parallel_for(
        std::size_t(t.vertex_count()), vertices_a_task, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                const VertexId v{int(i)};
                const subd::LimitPoint at =
                    limit.evaluate(cage.points, subd::corner_location(t, t.corner(v)), 1);
                const auto path = paths.find(v);
                targets.row(Eigen::Index(i)) =
                    path != paths.end()
                        ? nearest_on_path(reference, *path->second, at.position).point.transpose()
                        : oriented_foot_point(reference, at.position, unit_or_none(at.normal),
                                              std::numeric_limits<double>::infinity(), nullptr)
                              .point.transpose();
            }
        });
    for (const CurveTarget& dart : matched.match.darts)
        targets.row(dart.vertex.value) = dart.point.transpose();
    for (const VertexTarget& corner : matched.match.corners)
        targets.row(corner.vertex.value) = corner.point.transpose();
    return targets;
}

}  // namespace patchwright::fit
