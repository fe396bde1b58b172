#include "support/joints.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::test {

namespace {

struct Place {
    const patch::Patch* patch;
    std::size_t side;
    double begin;  // of the use on the side
    bool reversed;
};

}  // namespace

Eigen::Vector2d on_side(const geom::BsplineSurface& surface, std::size_t side, double s) {
    const double u = surface.knots_u.back(), v = surface.knots_v.back();
    switch (side) {
        case 0: return {s, 0};
        case 1: return {u, s};
        case 2: return {u - s, v};
        default: return {0, v - s};
    }
}

std::vector<Joint> measure_joints(const patch::PatchSet& set, int spans) {
    std::vector<std::vector<Place>> places(set.edges.size());
    for (const patch::Patch& patch : set.patches) {
        for (std::size_t side = 0; side < 4; ++side) {
            double begin = 0.0;
            for (const patch::EdgeUse& use : patch.sides[side]) {
                places[std::size_t(use.edge)].push_back({&patch, side, begin, use.reversed});
                begin += set.edges[std::size_t(use.edge)].curve.end();
            }
        }
    }
    std::vector<Joint> joints;
    for (std::size_t e = 0; e < places.size(); ++e) {
        const auto& curve = set.edges[e].curve;
        const double length = curve.end();
        std::vector<double> parameters;
        for (int k = 0; k <= spans * int(length); ++k) parameters.push_back(double(k) / spans);
        for (double t = 0.5 / spans; t > 1e-4; t *= 0.45) {
            parameters.push_back(t);
            parameters.push_back(length - t);
        }
        Joint joint{.edge = int(e), .crease = set.edges[e].crease};
        for (const double t : parameters) {
            std::vector<geom::Vec3> normals;
            for (const Place& p : places[e]) {
                const double s = p.begin + (p.reversed ? length - t : t);
                const Eigen::Vector2d uv = on_side(p.patch->surface, p.side, s);
                const auto value = p.patch->surface.at(uv.x(), uv.y());
                joint.gap = std::max(joint.gap, (value.position - curve.at(t)).norm());
                const geom::Vec3 n = value.du.cross(value.dv);
                joint.flat = joint.flat || n.norm() < 1e-9 * value.du.norm() * value.dv.norm();
                normals.push_back(n.normalized());
            }
            if (normals.size() != 2) continue;
            const double kink = 2.0 * std::atan2((normals[0] - normals[1]).norm(),
                                                 (normals[0] + normals[1]).norm());
            if (kink > joint.kink) {
                joint.kink = kink;
                joint.at = t / length;
            }
        }
        joints.push_back(joint);
    }
    return joints;
}

}  // namespace patchwright::test
