#include "occ/heal/free_edge_gaps.h"

#include "occ/exchange/cad_model_impl.h"
#include "occ/foot/curve_search.h"
#include "occ/foot/tight_bounds.h"

#include <BRep_Tool.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>

#include <algorithm>
#include <limits>
#include <numeric>

namespace patchwright::occ {

namespace {

std::vector<ModelEdge> free_edges(const TopoDS_Shape& shape) {
    TopTools_IndexedMapOfShape edges;
    const std::vector<int> uses = edge_uses(shape, edges);
    std::vector<ModelEdge> result;
    for (std::size_t i = 0; i < uses.size(); ++i) {
        if (uses[i] != 1) continue;
        ModelEdge edge;
        edge.curve = BRep_Tool::Curve(TopoDS::Edge(edges(int(i) + 1)), edge.first, edge.last);
        if (!edge.curve.IsNull() && edge.first < edge.last) result.push_back(std::move(edge));
    }
    return result;
}

constexpr int samples_of_edge = 17;  // within it

geom::Vec3 sample(const ModelEdge& edge, int k) {
    return edge.at(edge.first + (k + 0.5) / samples_of_edge * (edge.last - edge.first));
}

}  // namespace

int count_free_edges_beyond(const TopoDS_Shape& shape, double reach_mm) {
    const std::vector<ModelEdge> edges = free_edges(shape);
    return int(std::count_if(edges.begin(), edges.end(), [&](const ModelEdge& edge) {
        const geom::Vec3 middle = sample(edge, samples_of_edge / 2);
        double farthest = 0.0;
        for (int k = 0; k < samples_of_edge; ++k)
            farthest = std::max(farthest, (sample(edge, k) - middle).norm());
        return farthest > reach_mm;
    }));
}

std::vector<double> free_edge_gaps(const TopoDS_Shape& shape) {
    // Of the shape's size: chords of the search tree; distances are exact whatever their length.
    constexpr double chord_rel = 1e-3;
    const std::vector<ModelEdge> edges = free_edges(shape);
    std::vector<int> all(edges.size());
    std::iota(all.begin(), all.end(), 0);
    const double size = tight_bounds(shape).diagonal();
    const CurveSearch search(edges, all, chord_rel * size, size);
    std::vector<double> gaps;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        double widest = 0.0;
        for (int k = 0; k < samples_of_edge; ++k) {
            const geom::Vec3 p = sample(edges[i], k);
            double nearest = std::numeric_limits<double>::infinity();
            search.visit(p, nearest, [&](const CurveHit& hit, double bound) {
                if (hit.edge != int(i)) nearest = std::min(nearest, hit.distance);
                return std::min(bound, nearest);
            });
            widest = std::max(widest, nearest);
        }
        gaps.push_back(widest);
    }
    std::sort(gaps.begin(), gaps.end());
    return gaps;
}

}  // namespace patchwright::occ
