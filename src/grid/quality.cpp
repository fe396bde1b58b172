#include "grid/cell_point.h"
#include "grid/quad_figures.h"

#include <patchwright/base/parallel.h>
#include <patchwright/grid/quality.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace patchwright::grid {

namespace {

double scaled_jacobian(const BlockPoints& p, int i, int j, int k) {
    double least = 1.0;
    for (int corner = 0; corner < 8; ++corner) {
        const int a = corner & 1, b = corner >> 1 & 1, c = corner >> 2;
        const geom::Vec3 at = p.at(i + a, j + b, k + c);
        geom::Vec3 di = p.at(i + 1 - a, j + b, k + c) - at;
        geom::Vec3 dj = p.at(i + a, j + 1 - b, k + c) - at;
        geom::Vec3 dk = p.at(i + a, j + b, k + 1 - c) - at;
        if (a != 0) di = -di;
        if (b != 0) dj = -dj;
        if (c != 0) dk = -dk;
        const double scale = di.norm() * dj.norm() * dk.norm();
        least = std::min(least, scale > 0.0 ? di.cross(dj).dot(dk) / scale : 0.0);
    }
    return least;
}

struct QualitySums {
    Spread min_angle, skewness, aspect, stretching, scaled_jacobian;
    std::int64_t folded = 0, negative = 0;

    void add(const QualitySums& other) {
        merge(min_angle, other.min_angle, false);
        merge(skewness, other.skewness, true);
        merge(aspect, other.aspect, true);
        merge(stretching, other.stretching, true);
        merge(scaled_jacobian, other.scaled_jacobian, false);
        folded += other.folded;
        negative += other.negative;
    }
};

/// Lines beside a block edge: the second and third point of those that leave it, per point of the
/// edge in its own direction.
struct Beside {
    int block = -1;
    std::vector<geom::Vec3> first, second;
};

}  // namespace

struct QualityMeter::State {
    const BlockSource& grid;
    std::vector<std::vector<EdgePlace>> places;
    QualitySums all;
    Spread orthogonality;
    std::vector<std::array<Beside, 2>> beside;  // per edge and place
    struct AtVertex {
        int cells = 0;
        double low = M_PI, high = 0.0, smallest = 0.0, largest = 0.0;
        geom::Vec3 at = geom::Vec3::Zero();
    };
    std::map<mesh::VertexId, AtVertex> vertices;
    std::int64_t point_count = 0, cell_count = 0;

    explicit State(const BlockSource& source)
        : grid(source),
          places(edge_places(source.plan().layout)),
          beside(source.plan().layout.edges.size()) {}

    QualitySums measure(int block, const BlockPoints& p, int j0, int j1, int k,
                        CellFields* fields) const;
    void look_at_corners(int block, const BlockPoints& p);
    void look_at_sides(int block, const BlockPoints& p);
};

QualitySums QualityMeter::State::measure(int block, const BlockPoints& p, int j0, int j1, int k,
                                         CellFields* fields) const {
    QualitySums sums;
    const int layers = std::max(p.nk - 1, 1);
    for (int j = j0; j < j1; ++j) {
        for (int i = 0; i + 1 < p.ni; ++i) {
            const std::array<geom::Vec3, 4> quad{p.at(i, j, k), p.at(i + 1, j, k),
                                                 p.at(i + 1, j + 1, k), p.at(i, j + 1, k)};
            const CellFigures f = quad_figures(quad);
            const geom::Vec3& at = quad[0];
            note(sums.min_angle, false, f.min_angle, block, i, j, k, at);
            note(sums.skewness, true, f.skewness, block, i, j, k, at);
            note(sums.aspect, true, f.aspect, block, i, j, k, at);
            sums.folded += f.folded ? 1 : 0;
            double jacobian = 0.0;
            if (p.nk > 1) {
                jacobian = scaled_jacobian(p, i, j, k);
                note(sums.scaled_jacobian, false, jacobian, block, i, j, k, at);
                sums.negative += jacobian <= 0.0 ? 1 : 0;
            }
            const auto stretch = [&](const geom::Vec3& a, const geom::Vec3& b,
                                     const geom::Vec3& c) {
                note(sums.stretching, true, ratio((b - a).norm(), (c - b).norm()), block, i, j, k,
                     b);
            };
            if (i + 2 < p.ni) stretch(quad[0], quad[1], p.at(i + 2, j, k));
            if (j + 2 < p.nj) stretch(quad[0], quad[3], p.at(i, j + 2, k));
            if (k + 2 < p.nk) stretch(quad[0], p.at(i, j, k + 1), p.at(i, j, k + 2));
            if (fields == nullptr) continue;
            const std::size_t cell =
                std::size_t(i) +
                std::size_t(p.ni - 1) * (std::size_t(j) + std::size_t(p.nj - 1) * std::size_t(k));
            fields->min_angle_deg[cell] = float(f.min_angle * 180.0 / M_PI);
            fields->skewness[cell] = float(f.skewness);
            fields->aspect[cell] = float(f.aspect);
            if (layers > 1 || p.nk > 1) fields->scaled_jacobian[cell] = float(jacobian);
        }
    }
    return sums;
}

void QualityMeter::State::look_at_corners(int number, const BlockPoints& p) {
    const Block& block = grid.plan().layout.blocks[std::size_t(number)];
    const mesh::Topology& t = *grid.plan().layout.cage.topology;
    const int ci = block.columns - 1, cj = block.rows - 1;
    const int pi = p.ni - 1, pj = p.nj - 1;
    // Corners of the block counter-clockwise: vertex, place and the steps into the block.
    const mesh::CornerId at[4] = {block.cell(0, 0), t.next(block.cell(ci, 0)),
                                  t.next(t.next(block.cell(ci, cj))),
                                  t.previous(block.cell(0, cj))};
    const int place[4][4] = {{0, 0, 1, 1}, {pi, 0, -1, 1}, {pi, pj, -1, -1}, {0, pj, 1, -1}};
    for (std::size_t c = 0; c < 4; ++c) {
        const auto [i, j, si, sj] = place[c];
        const geom::Vec3 corner = p.at(i, j);
        const geom::Vec3 a = p.at(i + si, j) - corner, b = p.at(i, j + sj) - corner;
        const double angle_here = angle(a, b);
        const double area =
            0.5 * (p.at(i + si, j + sj) - corner).cross(p.at(i, j + sj) - p.at(i + si, j)).norm();
        AtVertex& v = vertices[t.vertex(at[c])];
        v.low = std::min(v.low, angle_here);
        v.high = std::max(v.high, angle_here);
        v.smallest = v.cells == 0 ? area : std::min(v.smallest, area);
        v.largest = std::max(v.largest, area);
        v.at = corner;
        ++v.cells;
    }
}

void QualityMeter::State::look_at_sides(int number, const BlockPoints& p) {
    const Block& block = grid.plan().layout.blocks[std::size_t(number)];
    for (int side = 0; side < 4; ++side) {
        const int length = side % 2 == 0 ? p.ni : p.nj;
        const int depth = side % 2 == 0 ? p.nj : p.ni;
        // The point `n` steps along the side, counter-clockwise, and `into` steps off it.
        const auto at = [&](int n, int into) {
            switch (side) {
                case 0: return p.at(n, into);
                case 1: return p.at(p.ni - 1 - into, n);
                case 2: return p.at(p.ni - 1 - n, p.nj - 1 - into);
                default: return p.at(into, p.nj - 1 - n);
            }
        };
        for (int n = 1; n + 1 < length; ++n) {
            const geom::Vec3 along = at(n + 1, 0) - at(n - 1, 0);
            const double off = std::abs(angle(along, at(n, 1) - at(n, 0)) - M_PI_2);
            const auto [i, j] = on_side({p.ni, p.nj}, side, n);
            note(orthogonality, true, off, number, i, j, 0, at(n, 0));
        }
        int begin = 0;
        const auto& uses = block.sides[std::size_t(side)];
        for (std::size_t u = 0; u < uses.size(); ++u) {
            const int cells = grid.plan().edges[std::size_t(uses[u].edge)].cells();
            const auto& users = places[std::size_t(uses[u].edge)];
            for (std::size_t place = 0; place < users.size(); ++place) {
                if (users[place].block != number || users[place].side != side ||
                    users[place].use != static_cast<int>(u)) {
                    continue;
                }
                Beside& lines = beside[std::size_t(uses[u].edge)][place];
                lines.block = number;
                for (int n = 0; n <= cells; ++n) {
                    const int k = uses[u].reversed ? begin + cells - n : begin + n;
                    lines.first.push_back(at(k, 1));
                    lines.second.push_back(at(k, std::min(2, depth - 1)));
                }
            }
            begin += cells;
        }
    }
}

QualityMeter::QualityMeter(const BlockSource& grid) : state_(std::make_unique<State>(grid)) {}
QualityMeter::~QualityMeter() = default;

void QualityMeter::add(int block, const BlockPoints& p, CellFields* fields) {
    const int layers = std::max(p.nk - 1, 1);
    const std::size_t cells = std::size_t(p.ni - 1) * std::size_t(p.nj - 1) * std::size_t(layers);
    if (fields != nullptr) {
        fields->min_angle_deg.resize(cells);
        fields->skewness.resize(cells);
        fields->aspect.resize(cells);
        fields->scaled_jacobian.resize(p.nk > 1 ? cells : 0);
    }
    const int rows = p.nj - 1;
    const int rows_a_task = std::max(1, 8192 / p.ni);
    const int tasks_a_layer = (rows + rows_a_task - 1) / rows_a_task;
    std::vector<QualitySums> parts(std::size_t(tasks_a_layer) * std::size_t(layers));
    base::parallel_for(parts.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t task = first; task < last; ++task) {
            const int k = int(task) / tasks_a_layer;
            const int j = int(task) % tasks_a_layer * rows_a_task;
            parts[task] = state_->measure(block, p, j, std::min(rows, j + rows_a_task), k, fields);
        }
    });
    for (const QualitySums& part : parts) state_->all.add(part);
    state_->look_at_corners(block, p);
    state_->look_at_sides(block, p);
    state_->point_count += std::int64_t(p.count());
    state_->cell_count += std::int64_t(cells);
}

GridQuality QualityMeter::result() const {
    const BlockLayout& layout = state_->grid.plan().layout;
    GridQuality q;
    q.blocks = static_cast<int>(layout.blocks.size());
    q.points = state_->point_count;
    q.cells = state_->cell_count;
    q.min_angle = finished(state_->all.min_angle);
    q.skewness = finished(state_->all.skewness);
    q.aspect = finished(state_->all.aspect);
    q.stretching = finished(state_->all.stretching);
    q.orthogonality = finished(state_->orthogonality);
    q.folded = state_->all.folded;
    if (state_->grid.layers() > 1) {
        q.scaled_jacobian = finished(state_->all.scaled_jacobian);
        q.negative = state_->all.negative;
    }
    for (std::size_t e = 0; e < layout.edges.size(); ++e) {
        if (state_->places[e].size() != 2) continue;
        ++q.interfaces;
        if (is_crease(layout, int(e))) continue;
        const auto& [a, b] = state_->beside[e];
        const geom::Points& points = state_->grid.plan().edges[e].points;
        for (std::size_t n = 1; n + 1 < a.first.size(); ++n) {
            const geom::Vec3 p = points.row(Eigen::Index(n)).transpose();
            const geom::Vec3 arriving = p - a.first[n], leaving = b.first[n] - p;
            const double beside = 0.5 * (angle(a.first[n] - a.second[n], arriving) +
                                         angle(leaving, b.second[n] - b.first[n]));
            note(q.turning, true, std::max(0.0, angle(arriving, leaving) - beside), a.block, int(n),
                 0, 0, p);
            note(q.jump, true, ratio(arriving.norm(), leaving.norm()), a.block, int(n), 0, 0, p);
        }
    }
    q.turning = finished(q.turning);
    q.jump = finished(q.jump);
    const mesh::Topology& t = *layout.cage.topology;
    for (const auto& [vertex, v] : state_->vertices) {
        if (!mesh::is_extraordinary(t, vertex) || t.is_boundary(vertex)) continue;
        q.extraordinary.push_back({vertex, v.cells, v.low, v.high,
                                   v.smallest > 0.0 ? v.largest / v.smallest : 0.0, v.at});
    }
    return q;
}

GridQuality measure_quality(const BlockSource& grid) {
    QualityMeter meter(grid);
    BlockPoints points;
    for (int b = 0; b < grid.block_count(); ++b) {
        grid.evaluate(b, points);
        meter.add(b, points);
    }
    return meter.result();
}

}  // namespace patchwright::grid
