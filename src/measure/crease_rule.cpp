#include <patchwright/measure/crease_rule.h>
#include <patchwright/subd/limit_operator.h>

#include <algorithm>

namespace patchwright::measure {

double distance_from_catmull_clark(const mesh::Cage& cage) {
    const mesh::Topology& t = *cage.topology;
    std::vector<subd::Site> sites;
    for (const mesh::FaceId f : t.faces())
        if (t.is_near_runout(f)) sites.push_back({.face = f});
    if (sites.empty()) return 0.0;
    constexpr int intervals = 4;
    subd::ParameterSet set;
    for (int i = 0; i <= intervals; ++i)
        for (int j = 0; j <= intervals; ++j)
            set.emplace_back(double(i) / intervals, double(j) / intervals);
    const subd::LimitOperator limit(t, {set}, sites, subd::SampleRows::PointsAndTangents);
    const geom::Points normals = limit.normals(cage.points).rowwise().normalized();
    geom::Points own, plain;
    limit.apply(cage.points, own);
    subd::LimitOperator(t.with(mesh::CreaseRule::CatmullClark), {set}, sites)
        .apply(cage.points, plain);
    return (own - plain).cwiseProduct(normals).rowwise().sum().cwiseAbs().maxCoeff();
}

}  // namespace patchwright::measure
