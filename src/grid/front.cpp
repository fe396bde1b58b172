#include "grid/front.h"

#include "geom/symmetric_eigen.h"
#include "grid/cell_point.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

namespace patchwright::grid {

namespace {

// Borders are planar to this share of their size, and the surface stands on the plane when its
// normal is farther than this from the plane's.
constexpr double planar = 1e-6;
constexpr double across = 0.7;

}  // namespace

FrontMesh::FrontMesh(const Plan& plan) {
    number_points(plan);
    gather_corners(plan);
    find_planes(plan);
}

void FrontMesh::number_points(const Plan& plan) {
    const mesh::Topology& t = *plan.layout.cage.topology;
    std::map<mesh::VertexId, std::int32_t> at_vertex;
    std::int32_t count = 0;
    on_edge_.resize(plan.edges.size());
    for (std::size_t e = 0; e < plan.edges.size(); ++e) {
        const auto& run = plan.layout.edges[e].run;
        const auto vertex = [&](mesh::VertexId v) {
            const auto [known, is_new] = at_vertex.try_emplace(v, count);
            if (is_new) ++count;
            return known->second;
        };
        on_edge_[e].push_back(vertex(t.vertex(run.front())));
        for (int k = 1; k < plan.edges[e].cells(); ++k) on_edge_[e].push_back(count++);
        on_edge_[e].push_back(vertex(t.vertex(t.next(run.back()))));
    }
    const BlockEvaluator evaluator(plan);
    numbers_.resize(plan.layout.blocks.size());
    std::vector<geom::Points> inner(numbers_.size());
    for (std::size_t b = 0; b < numbers_.size(); ++b) {
        const auto [ni, nj] = plan.size(int(b));
        std::vector<std::int32_t>& numbers = numbers_[b];
        numbers.assign(std::size_t(ni) * std::size_t(nj), -1);
        for (int side = 0; side < 4; ++side) {
            int begin = 0;
            for (const BlockEdgeUse& use : plan.layout.blocks[b].sides[std::size_t(side)]) {
                const auto& edge = on_edge_[std::size_t(use.edge)];
                const int cells = int(edge.size()) - 1;
                for (int k = 0; k <= cells; ++k) {
                    const auto [i, j] = on_side({ni, nj}, side, begin + k);
                    numbers[std::size_t(i) + std::size_t(ni) * std::size_t(j)] =
                        edge[std::size_t(use.reversed ? cells - k : k)];
                }
                begin += cells;
            }
        }
        for (std::int32_t& number : numbers) {
            if (number < 0) number = count++;
        }
    }
    surface_.resize(count, 3);
    BlockPoints points;
    for (std::size_t b = 0; b < numbers_.size(); ++b) {
        evaluator.evaluate(int(b), points);
        for (std::size_t n = 0; n < numbers_[b].size(); ++n) {
            for (std::size_t c = 0; c < 3; ++c) {
                surface_(numbers_[b][n], Eigen::Index(c)) = points.coordinates[c][n];
            }
        }
    }
}

std::vector<std::array<std::int32_t, 4>> FrontMesh::cells(const Plan& plan) const {
    std::vector<std::array<std::int32_t, 4>> all;
    all.reserve(std::size_t(plan.cell_count()));
    for (std::size_t b = 0; b < numbers_.size(); ++b) {
        const auto [ni, nj] = plan.size(int(b));
        const auto at = [&, width = ni](int i, int j) {
            return numbers_[b][std::size_t(i) + std::size_t(width) * std::size_t(j)];
        };
        for (int j = 0; j + 1 < nj; ++j)
            for (int i = 0; i + 1 < ni; ++i)
                all.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    return all;
}

void FrontMesh::gather_corners(const Plan& plan) {
    std::vector<std::size_t> count(std::size_t(surface_.rows()) + 1, 0);
    const auto all = cells(plan);
    for (const auto& cell : all)
        for (const std::int32_t p : cell) ++count[std::size_t(p) + 1];
    for (std::size_t p = 1; p < count.size(); ++p) count[p] += count[p - 1];
    begin_ = count;
    corners_.resize(begin_.back());
    for (const auto& cell : all)
        for (std::size_t k = 0; k < 4; ++k)
            corners_[count[std::size_t(cell[k])]++] = {cell[(k + 1) % 4], cell[(k + 3) % 4]};
}

void FrontMesh::find_planes(const Plan& plan) {
    planes_.assign(size(), geom::Vec3::Zero());
    const auto places = edge_places(plan.layout);
    // Free edges that hang together are one border.
    std::map<std::int32_t, std::vector<std::size_t>> at_end;
    std::vector<char> done(places.size(), 1);
    for (std::size_t e = 0; e < places.size(); ++e) {
        if (places[e].size() != 1) continue;
        done[e] = 0;
        at_end[on_edge_[e].front()].push_back(e);
        at_end[on_edge_[e].back()].push_back(e);
    }
    for (std::size_t seed = 0; seed < places.size(); ++seed) {
        if (done[seed] != 0) continue;
        std::vector<std::size_t> open{seed}, border;
        done[seed] = 1;
        while (!open.empty()) {
            const std::size_t e = open.back();
            open.pop_back();
            border.push_back(e);
            for (const std::int32_t end : {on_edge_[e].front(), on_edge_[e].back()}) {
                for (const std::size_t other : at_end[end]) {
                    if (done[other] == 0) open.push_back(other);
                    done[other] = 1;
                }
            }
        }
        std::vector<std::int32_t> points;
        for (const std::size_t e : border) {
            points.insert(points.end(), on_edge_[e].begin(), on_edge_[e].end());
        }
        geom::Vec3 centre = geom::Vec3::Zero();
        for (const std::int32_t p : points) centre += surface_.row(p).transpose();
        centre /= double(points.size());
        Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
        for (const std::int32_t p : points) {
            const geom::Vec3 d = surface_.row(p).transpose() - centre;
            spread += d * d.transpose();
        }
        const geom::Vec3 normal = geom::symmetric_eigen(spread).vectors.col(0);
        double off = 0.0, far = 0.0, lean = 0.0;
        for (const std::int32_t p : points) {
            const geom::Vec3 d = surface_.row(p).transpose() - centre;
            off = std::max(off, std::abs(d.dot(normal)));
            far = std::max(far, d.norm());
            geom::Vec3 n = geom::Vec3::Zero();
            for (const Corner& c : corners(std::size_t(p))) {
                n += (surface_.row(c.next) - surface_.row(p))
                         .transpose()
                         .cross((surface_.row(c.previous) - surface_.row(p)).transpose());
            }
            lean = std::max(lean, std::abs(n.normalized().dot(normal)));
        }
        if (off > planar * far || lean > across) continue;
        for (const std::int32_t p : points) planes_[std::size_t(p)] = normal;
    }
}

}  // namespace patchwright::grid
