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

}  // namespace

std::vector<double> free_edge_gaps(const TopoDS_Shape& shape) {
    constexpr int samples = 17;
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
        for (int k = 0; k < samples; ++k) {
            const double share = (k + 0.5) / samples;
            const geom::Vec3 p =
                edges[i].at(edges[i].first + share * (edges[i].last - edges[i].first));
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
