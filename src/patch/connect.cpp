#include "patch/connect.h"

#include "patch/fan.h"

#include <algorithm>

namespace patchwright::patch {

using mesh::CornerId;
using mesh::EdgeId;
using mesh::Topology;
using mesh::VertexId;

namespace {

/// The boundary curve of side i (v = 0, u = 1, v = 1, u = 0), in counter-clockwise direction.
geom::BsplineCurve side_curve(const geom::BsplineSurface& s, int side) {
    const bool along_u = side % 2 == 0;
    const Eigen::Index count = along_u ? s.rows() : s.columns();
    geom::BsplineCurve curve{along_u ? s.knots_u : s.knots_v, geom::Points(count, 3)};
    for (Eigen::Index k = 0; k < count; ++k) {
        curve.points.row(k) = side == 0   ? s.point(k, 0)
                              : side == 1 ? s.point(s.rows() - 1, k)
                              : side == 2 ? s.point(k, s.columns() - 1)
                                          : s.point(0, k);
    }
    return side < 2 ? curve : reversed(curve);
}

/// Half-edges that follow each other on the side of a chart between two ends of edges.
struct SideRun {
    std::vector<CornerId> half_edges;
    double begin = 0.0;  ///< where on the side it starts, in faces
};

class Connector {
  public:
    Connector(const Topology& t, const std::vector<Chart>& charts,
              const std::vector<EdgeContinuity>& at_vertex, PatchSet& set)
        : t_(t),
          charts_(charts),
          at_vertex_(at_vertex),
          set_(set),
          vertex_(std::size_t(t.vertex_count()), -1) {
        find_ends();
        edge_.resize(std::size_t(t.edge_count()), -1);
        for (std::size_t k = 0; k < charts.size(); ++k) {
            for (int side = 0; side < 4; ++side) connect_side(k, side);
        }
        set.vertices.resize(ends_, 3);
        for (const PatchEdge& edge : set.edges) {
            set.vertices.row(edge.start) = edge.curve.points.row(0);
            set.vertices.row(edge.end) = edge.curve.points.row(edge.curve.points.rows() - 1);
        }
    }

  private:
    [[nodiscard]] bool is_end(VertexId v) const { return vertex_[v.index()] >= 0; }
    void make_end(VertexId v) {
        if (!is_end(v)) vertex_[v.index()] = ends_++;
    }

    void find_ends() {
        for (const Chart& chart : charts_) {
            for (int side = 0; side < 4; ++side) {
                make_end(t_.vertex(chart.side(t_, side).front()));
            }
        }
        // An edge that closes onto itself is split: some CAD programs refuse such edges.
        for (const Chart& chart : charts_) {
            for (int side = 0; side < 4; ++side) {
                for (const SideRun& run : runs(chart, side)) {
                    const auto& edges = run.half_edges;
                    if (t_.vertex(edges.front()) == t_.vertex(t_.next(edges.back()))) {
                        make_end(t_.vertex(edges[edges.size() / 2]));
                    }
                }
            }
        }
    }

    [[nodiscard]] std::vector<SideRun> runs(const Chart& chart, int side) const {
        std::vector<SideRun> runs;
        const std::vector<CornerId> half_edges = chart.side(t_, side);
        for (std::size_t k = 0; k < half_edges.size(); ++k) {
            if (k == 0 || is_end(t_.vertex(half_edges[k]))) runs.push_back({{}, double(k)});
            runs.back().half_edges.push_back(half_edges[k]);
        }
        return runs;
    }

    void connect_side(std::size_t k, int side) {
        Patch& patch = set_.patches[k];
        const geom::BsplineCurve whole = side_curve(patch.surface, side);
        for (const SideRun& run : runs(charts_[k], side)) {
            const double end = run.begin + double(run.half_edges.size());
            geom::BsplineCurve curve = part(whole, run.begin, end);
            for (double& knot : curve.knots) knot -= run.begin;
            const EdgeId mesh_edge = t_.edge(run.half_edges.front());
            const int known = edge_[mesh_edge.index()];
            if (known < 0) {
                const int number = static_cast<int>(set_.edges.size());
                for (const CornerId c : run.half_edges) edge_[t_.edge(c).index()] = number;
                const VertexId from = t_.vertex(run.half_edges.front());
                const VertexId to = t_.vertex(t_.next(run.half_edges.back()));
                const bool sharp = is_sharp(t_, mesh_edge);
                set_.edges.push_back({.start = vertex_[from.index()],
                                      .end = vertex_[to.index()],
                                      .curve = std::move(curve),
                                      .crease = sharp && !t_.is_boundary(mesh_edge),
                                      .continuity = sharp ? EdgeContinuity::Position
                                                          : std::min(at_vertex_[from.index()],
                                                                     at_vertex_[to.index()])});
                patch.sides[std::size_t(side)].push_back({number, false});
            } else {
                // Both sides have the same curve; the one with fewer knots says so more simply.
                PatchEdge& edge = set_.edges[std::size_t(known)];
                if (curve.knots.size() < edge.curve.knots.size()) edge.curve = reversed(curve);
                patch.sides[std::size_t(side)].push_back({known, true});
            }
        }
    }

    const Topology& t_;
    const std::vector<Chart>& charts_;
    const std::vector<EdgeContinuity>& at_vertex_;
    PatchSet& set_;
    std::vector<int> vertex_;  // per vertex of the mesh: number of the set's vertex, or -1
    std::vector<int> edge_;    // per edge of the mesh: number of the set's edge, or -1
    int ends_ = 0;
};

}  // namespace

void connect(const Topology& t, const std::vector<Chart>& charts,
             const std::vector<EdgeContinuity>& at_vertex, PatchSet& set) {
    Connector(t, charts, at_vertex, set);
}

}  // namespace patchwright::patch
