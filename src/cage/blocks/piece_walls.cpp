#include "cage/blocks/piece_mesh.h"

#include <patchwright/base/numbers.h>

#include <algorithm>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

std::vector<std::pair<int, int>> EdgeSet::sorted() const {
    std::vector<std::pair<int, int>> edges;
    for (const std::uint64_t k : keys_) edges.emplace_back(int(k >> 32), int(std::uint32_t(k)));
    std::sort(edges.begin(), edges.end());
    return edges;
}

void PieceMesh::link(int triangle) {
    const auto& c = mesh_.triangle(triangle);
    for (int k = 0; k < 3; ++k) {
        const int a = c[at(k)], b = c[at((k + 1) % 3)];
        const geom::EdgeSides s = mesh_.sides(a, b);
        const bool wall = walls_.contains(a, b);
        for (std::size_t i = 0; i < 2; ++i)
            if (s.triangle[i] >= 0)
                beyond_[at(s.triangle[i])][at(s.side[i])] = wall ? -1 : s.triangle[1 - i];
    }
}

void PieceMesh::add_wall(int a, int b) {
    walls_.insert(a, b);
    const geom::EdgeSides s = mesh_.sides(a, b);
    for (std::size_t i = 0; i < 2; ++i)
        if (s.triangle[i] >= 0) beyond_[at(s.triangle[i])][at(s.side[i])] = -1;
}

int PieceMesh::split(int a, int b, const Vec3& where) {
    const int middle = mesh_.split(a, b, where);
    node_.push_back(0);
    natural_.push_back(0);
    if (walls_.contains(a, b)) {
        walls_.erase(a, b);
        walls_.insert(a, middle);
        walls_.insert(middle, b);
    }
    beyond_.resize(at(mesh_.triangle_count()), {-1, -1, -1});
    for (const int t : mesh_.fan(middle)) link(t);
    return middle;
}

int PieceMesh::split_wall(int a, int b) {
    const geom::EdgeSides s = mesh_.sides(a, b);
    const int curve = mesh_.curve(s.triangle[0], s.side[0]);
    Vec3 middle = 0.5 * (mesh_.point(a) + mesh_.point(b));
    middle = curve >= 0 ? reference_.nearest_on_curve(curve, middle).point
                        : reference_.foot_point(middle, mesh_.vertex_normal(a)).point;
    const int m = split(a, b, middle);
    const auto move_sector = [&](int from, int to) {
        const auto known = sectors_.find({from, to});
        if (known == sectors_.end()) return;
        const WallSector sector = known->second;
        sectors_.erase(known);
        sectors_[{from, m}] = sector;
    };
    move_sector(a, b);
    move_sector(b, a);
    for (auto& path : cuts_)
        for (std::size_t i = 0; i + 1 < path.size(); ++i)
            if (std::minmax(path[i], path[i + 1]) == std::minmax(a, b)) {
                path.insert(path.begin() + std::ptrdiff_t(i) + 1, m);
                break;
            }
    return m;
}

void PieceMesh::add_lines(const FieldLines& made) {
    std::map<int, int> walls_at;
    for (const auto& line : made.lines) {
        if (line.empty()) continue;
        for (std::size_t i = 0; i + 1 < line.size(); ++i) add_wall(line[i], line[i + 1]);
        make_node(line.front());
        make_node(line.back());
        cuts_.push_back(line);
    }
    for (const auto& [a, b] : walls_.sorted()) {
        ++walls_at[a];
        ++walls_at[b];
    }
    for (const auto& [v, count] : walls_at)
        if (count > 2) make_node(v);
    for (const FieldSector& s : made.sectors) {
        if (s.quads != 2) make_node(s.vertex);
        sectors_[{s.vertex, s.next}] = {s.angle, s.quads};
    }
}

}  // namespace patchwright::cage
