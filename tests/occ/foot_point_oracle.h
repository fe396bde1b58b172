// Foot points of a model against the kernel's search for the shortest distance.
#pragma once

#include "occ/foot/foot_point_engine.h"
#include "occ/shapes.h"

#include <BRepBuilderAPI_MakeFace.hxx>
#include <Geom_BezierSurface.hxx>
#include <TColgp_Array2OfPnt.hxx>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace patchwright::test {

/// A sheet of waves as count x count bicubic faces over a square of size 1000, which meet at
/// small angles and share no edges.
inline occ::CadModel wavy_sheet(int count) {
    const auto height = [](double x, double y) {
        return 40.0 * std::sin(0.011 * x) * std::cos(0.013 * y);
    };
    TopoDS_Compound faces;
    const BRep_Builder builder;
    builder.MakeCompound(faces);
    const double size = 1000.0 / count;
    for (int i = 0; i < count * count; ++i) {
        TColgp_Array2OfPnt poles(1, 4, 1, 4);
        for (int k = 0; k < 16; ++k) {
            const double x = size * (i % count + (k % 4) / 3.0);
            const double y = size * (i / count + (k / 4) / 3.0);
            poles(k % 4 + 1, k / 4 + 1) = gp_Pnt(x, y, height(x, y));
        }
        builder.Add(faces, BRepBuilderAPI_MakeFace(new Geom_BezierSurface(poles), 1e-7).Face());
    }
    return model_of(faces);
}

struct OracleQuery {
    std::string kind;
    geom::Vec3 point;
};

/// Points of all kinds, about `count` in all: near, on the surface, far, inside the bounds, beyond
/// trimmed edges (off free and sharp edges, away from the face), at vertices and degenerate tips.
inline std::vector<OracleQuery> oracle_queries(const occ::CadReference& reference, int count,
                                               unsigned seed) {
    const geom::Box3 box = reference.bounds();
    const double size = box.diagonal();
    std::mt19937 random(seed);
    std::normal_distribution<> normal;
    std::uniform_real_distribution<> share;
    const auto direction = [&] {
        return geom::Vec3(normal(random), normal(random), normal(random)).normalized();
    };
    auto samples = reference.sample(10 * count);
    std::shuffle(samples.begin(), samples.end(), random);
    std::vector<OracleQuery> queries;
    const int each = std::max(count / 6, 1);
    for (int i = 0; i < each; ++i) {
        const auto& sample = samples[std::size_t(i) % samples.size()];
        queries.push_back({"near", sample.point + 0.02 * size * share(random) * direction()});
        queries.push_back({"on", sample.point});
        queries.push_back({"far", box.centre() + size * (0.6 + 3.0 * share(random)) * direction()});
        const geom::Vec3 place(share(random), share(random), share(random));
        queries.push_back({"inside", box.min + place.cwiseProduct(box.max - box.min)});
    }
    const auto& network = reference.search_model().network;
    for (int i = 0; i < each && !network.edges.empty(); ++i) {
        const occ::ModelEdge& edge = network.edges[random() % network.edges.size()];
        const double t = edge.first + share(random) * (edge.last - edge.first);
        geom::Vec3 away = geom::Vec3::Zero();
        for (const occ::FaceOfEdge& use : edge.uses)
            away += occ::normal_beside(edge, use, t, reference.search_model().surfaces);
        away += edge.tangent(t).cross(direction());
        queries.push_back({"beyond", edge.at(t) + 0.02 * size * share(random) * away.normalized()});
    }
    for (int i = 0; i < each && !network.vertices.empty(); ++i) {
        const geom::Vec3& tip = network.vertices[random() % network.vertices.size()];
        queries.push_back({"tip", tip + 0.01 * size * share(random) * direction()});
    }
    return queries;
}

struct OracleResult {
    int points = 0;
    int kernel_farther = 0;  ///< the kernel missed a nearer point by more than the tolerance
    double farther = 0.0;    ///< largest excess over the kernel's distance, millimetres
    OracleQuery worst{"", geom::Vec3::Zero()};
    std::map<std::string, int> kinds;
};

inline OracleResult compare_with_kernel(const occ::CadReference& reference,
                                        const TopoDS_Shape& faces, int count, unsigned seed,
                                        double tolerance) {
    OracleResult result;
    for (const OracleQuery& query : oracle_queries(reference, count, seed)) {
        const double kernel = kernel_distance(faces, query.point);
        if (kernel < 0.0) continue;
        ++result.points;
        ++result.kinds[query.kind];
        const double excess = reference.foot_point(query.point).distance - kernel;
        result.kernel_farther += excess < -tolerance ? 1 : 0;
        if (excess <= result.farther) continue;
        result.farther = excess;
        result.worst = query;
    }
    return result;
}

}  // namespace patchwright::test
