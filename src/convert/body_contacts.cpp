#include "convert/body_contacts.h"

#include <Eigen/QR>

namespace patchwright::convert {

namespace {

/// Newton's method from nearby takes three or four; what takes more leads elsewhere.
constexpr int most_steps = 10;
/// Of a unit normal: tangent planes that differ by less count as parallel.
constexpr double parallel = 1e-3;
/// Of the tolerance: where bodies of the output cross, those of the input are as near as this, if
/// the tolerance is met; and their points where they cross themselves.
constexpr double contact_reach = 2.0, contact_share = 1e-3;

bool surfaces_meet(const geom::ReferenceSurface& a, const geom::ReferenceSurface& b,
                   geom::Vec3 point, double common_mm) {
    for (int step = 0; step < most_steps; ++step) {
        const geom::FootPoint on_a = a.foot_point(point), on_b = b.foot_point(point);
        if ((on_a.point - on_b.point).norm() <= common_mm) return true;
        // The nearest point of both tangent planes; halfway between them where they are parallel.
        Eigen::Matrix<double, 2, 3> normals;
        normals << on_a.normal.transpose(), on_b.normal.transpose();
        const Eigen::Vector2d heights(on_a.normal.dot(on_a.point - point),
                                      on_b.normal.dot(on_b.point - point));
        Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix<double, 2, 3>> planes;
        planes.setThreshold(parallel);
        planes.compute(normals);
        point += planes.solve(heights);
    }
    return false;
}

}  // namespace

bool bodies_meet(const BodySurfaces& bodies, const geom::Vec3& point, double reach_mm,
                 double common_mm) {
    std::vector<const geom::ReferenceSurface*> near;
    for (const auto& body : bodies)
        if (body->foot_point(point).distance <= reach_mm) near.push_back(body.get());
    for (std::size_t i = 0; i < near.size(); ++i)
        for (std::size_t j = i + 1; j < near.size(); ++j)
            if (surfaces_meet(*near[i], *near[j], point, common_mm)) return true;
    return false;
}

void find_new_crossings(ShapeFigures& figures, const BodySurfaces& input, double tolerance_mm) {
    auto& crossing = figures.crossing_bodies;
    std::erase_if(crossing, [&](const measure::SelfIntersection& hit) {
        return bodies_meet(input, hit.point, contact_reach * tolerance_mm,
                           contact_share * tolerance_mm);
    });
    auto& faults = figures.self_intersections;
    faults.insert(faults.end(), crossing.begin(), crossing.end());
}

}  // namespace patchwright::convert
