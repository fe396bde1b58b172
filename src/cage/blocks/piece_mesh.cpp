#include "cage/blocks/piece_mesh.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Of the diagonal: how far from a vertex on a feature its direction is taken.
constexpr double step_rel = 1e-4;
// Cosine of the turn, 41 degrees, from which on a wall has a node there.
constexpr double kink_cosine = 0.75;
// Of an edge: farther from its middle the nearest point of the model is on another sheet.
constexpr double nearest_reach = 0.3;
// What is split may leave other edges from wall to wall at first.
constexpr int bridge_rounds = 2;
// Rounds of moving vertices to the middle of their neighbours that straighten cuts; in each so many
// they are put onto the model.
constexpr int smoothing_rounds = 60, project_every = 5;

/// Where the angle of a border asks for one face, two, three or four.
int faces_for(double angle) { return std::clamp(int(std::lround(angle / (0.5 * M_PI))), 1, 4); }

}  // namespace

int first_corner(const Border& border) {
    const auto corner = std::find_if(border.begin(), border.end(),
                                     [](const BorderPoint& p) { return p.faces == 1; });
    return corner == border.end() ? -1 : int(corner - border.begin());
}

PieceMesh::PieceMesh(geom::EditableMesh& mesh, const geom::ModelSurface& reference)
    : mesh_(mesh), reference_(reference) {
    for (int t = 0; t < mesh_.triangle_count(); ++t) {
        if (!mesh_.alive(t)) continue;
        for (int k = 0; k < 3; ++k) {
            const auto& c = mesh_.triangle(t);
            const int a = c[at(k)], b = c[at((k + 1) % 3)];
            if (mesh_.curve(t, k) >= 0 || mesh_.sides(a, b).triangle[1] < 0) walls_.insert(a, b);
        }
    }
    beyond_.assign(at(mesh_.triangle_count()), {-1, -1, -1});
    for (int t = 0; t < mesh_.triangle_count(); ++t)
        if (mesh_.alive(t)) link(t);
    node_.assign(at(mesh_.vertex_count()), 0);
    find_nodes();
    natural_ = node_;
    widen_corners();
}

/// Ends and junctions of walls, and places where one bends.
void PieceMesh::find_nodes() {
    std::map<int, std::vector<int>> next;
    for (const auto& [a, b] : walls_.sorted()) {
        next[a].push_back(b);
        next[b].push_back(a);
    }
    const double step = step_rel * reference_.size();
    for (const auto& [v, others] : next) {
        bool node = others.size() != 2 || mesh_.corner(v) >= 0;
        if (!node) {
            std::array<Vec3, 2> ways;
            std::array<int, 2> curves{-1, -1};
            for (std::size_t i = 0; i < 2; ++i) {
                const geom::EdgeSides s = mesh_.sides(v, others[i]);
                const int curve = mesh_.curve(s.triangle[0], s.side[0]);
                ways[i] = (mesh_.point(others[i]) - mesh_.point(v)).normalized();
                curves[i] = curve;
                if (curve < 0) continue;
                const Vec3 near = mesh_.point(v) + step * ways[i];
                const geom::FeaturePoint p = reference_.nearest_on_curve(curve, near);
                ways[i] = p.tangent.dot(ways[i]) < 0.0 ? Vec3(-p.tangent) : p.tangent;
            }
            node = curves[0] != curves[1] || -ways[0].dot(ways[1]) < kink_cosine;
        }
        if (node) node_[at(v)] = 1;
    }
}

double PieceMesh::angle_from(int v, int next) const {
    const geom::EdgeSides first = mesh_.sides(v, next);
    int t = -1, k = -1;
    for (std::size_t i = 0; i < 2 && t < 0; ++i) {
        if (first.triangle[i] < 0) continue;
        const int corner = mesh_.corner_of(first.triangle[i], v);
        if (mesh_.triangle(first.triangle[i])[at((corner + 1) % 3)] != next) continue;
        t = first.triangle[i];
        k = corner;
    }
    double angle = 0.0;
    while (t >= 0) {
        angle += mesh_.corner_angle(t, k);
        const int other = mesh_.triangle(t)[at((k + 2) % 3)];
        if (is_wall(v, other)) break;
        const geom::EdgeSides s = mesh_.sides(v, other);
        t = s.triangle[0] == t ? s.triangle[1] : s.triangle[0];
        if (t >= 0) k = mesh_.corner_of(t, v);
    }
    return angle;
}

/// Where two pieces meet with a corner of each, as the two sides of a plate do, one of them gets
/// two quads there: an inner vertex needs three.
void PieceMesh::widen_corners() {
    std::vector<int> piece_of(at(mesh_.triangle_count()), -1);
    for (const int seed : seeds())
        for (const int t : triangles_from(seed)) piece_of[at(t)] = seed;
    for (int v = 0; v < int(natural_.size()); ++v) {
        if (natural_[at(v)] == 0 || mesh_.is_boundary(v)) continue;
        int walls = 0, chosen = -1, lowest = -1;
        bool narrow = true;
        for (const int w : mesh_.neighbours(v)) {
            if (!is_wall(v, w)) continue;
            ++walls;
            narrow = narrow && faces_for(angle_from(v, w)) == 1;
            const geom::EdgeSides s = mesh_.sides(v, w);
            for (const int t : s.triangle) {
                const int k = mesh_.corner_of(t, v);
                const bool starts = mesh_.triangle(t)[at((k + 1) % 3)] == w;
                if (!starts || (lowest >= 0 && piece_of[at(t)] > lowest)) continue;
                lowest = piece_of[at(t)];
                chosen = w;
            }
        }
        if (walls == 2 && narrow) sectors_[{v, chosen}] = {angle_from(v, chosen), 2};
    }
}

std::vector<int> PieceMesh::triangles_from(int triangle) const {
    std::vector<int> result{triangle};
    std::vector<char> seen(at(mesh_.triangle_count()), 0);
    seen[at(triangle)] = 1;
    for (std::size_t i = 0; i < result.size(); ++i) {
        for (const int t : beyond_[at(result[i])]) {
            if (t < 0 || seen[at(t)] != 0) continue;
            seen[at(t)] = 1;
            result.push_back(t);
        }
    }
    std::sort(result.begin(), result.end());
    return result;
}

std::vector<int> PieceMesh::seeds() const {
    std::vector<char> seen(at(mesh_.triangle_count()), 0);
    std::vector<int> result;
    for (int t = 0; t < mesh_.triangle_count(); ++t) {
        if (!mesh_.alive(t) || seen[at(t)] != 0) continue;
        result.push_back(t);
        for (const int other : triangles_from(t)) seen[at(other)] = 1;
    }
    return result;
}

bool PieceMesh::split_bridges(const std::vector<int>& triangles) {
    std::vector<char> on_wall(at(mesh_.vertex_count()), 0);
    for (const int t : triangles) {
        const auto& c = mesh_.triangle(t);
        for (std::size_t k = 0; k < 3; ++k)
            if (beyond_[at(t)][k] < 0) on_wall[at(c[k])] = on_wall[at(c[(k + 1) % 3])] = 1;
    }
    // A vertex can be on a wall of this piece with a triangle that has no wall itself.
    std::set<std::pair<int, int>> bridges;
    for (const int t : triangles) {
        const auto& c = mesh_.triangle(t);
        for (std::size_t k = 0; k < 3; ++k) {
            const int a = c[k], b = c[(k + 1) % 3];
            if (on_wall[at(a)] != 0 && on_wall[at(b)] != 0 && beyond_[at(t)][k] >= 0)
                bridges.insert(std::minmax(a, b));
        }
    }
    for (const auto& [a, b] : bridges) {
        const geom::EdgeSides s = mesh_.sides(a, b);
        const Vec3 middle = 0.5 * (mesh_.point(a) + mesh_.point(b));
        const Vec3 normal =
            (mesh_.area_vector(s.triangle[0]) + mesh_.area_vector(s.triangle[1])).normalized();
        const geom::FootPoint foot = normal.allFinite() ? reference_.foot_point(middle, normal)
                                                        : reference_.foot_point(middle);
        const bool near = foot.distance < nearest_reach * (mesh_.point(a) - mesh_.point(b)).norm();
        split(a, b, near ? foot.point : middle);
    }
    return !bridges.empty();
}

/// Goes round the border that side k of triangle t is part of.
void PieceMesh::walk_border(CutPiece& piece, const std::vector<int>& local, int t, int k,
                            std::vector<std::array<char, 3>>& walked) const {
    Border border;
    const int base = int(piece.vertices.size());
    // One step: from side k of triangle t to the side that follows it on the border.
    int tri = t, side = k;
    do {
        walked[at(local[at(tri)])][at(side)] = 1;
        const int end = mesh_.triangle(tri)[at((side + 1) % 3)];
        double angle = 0.0;
        while (true) {
            side = mesh_.corner_of(tri, end);
            piece.corners[at(local[at(tri)])][at(side)] = base + int(border.size());
            angle += mesh_.corner_angle(tri, side);
            const int onward = beyond_[at(tri)][at(side)];
            if (onward < 0) break;
            tri = onward;
        }
        BorderPoint p;
        p.vertex = end;
        p.next = mesh_.triangle(tri)[at((side + 1) % 3)];
        p.angle = angle;
        p.node = is_node(end);
        const auto known = sectors_.find({p.vertex, p.next});
        if (known != sectors_.end()) {
            p.angle = known->second.angle;
            p.faces = known->second.faces;
        } else if (natural_[at(end)] != 0) {
            p.faces = faces_for(angle);
        }
        border.push_back(p);
    } while (tri != t || side != k);
    for (std::size_t i = 0; i < border.size(); ++i) {
        piece.vertices.push_back(border[i].vertex);
        piece.border_places.emplace_back(int(piece.borders.size()), int(i));
    }
    piece.borders.push_back(std::move(border));
}

CutPiece PieceMesh::piece(int triangle) {
    CutPiece piece;
    piece.triangles = triangles_from(triangle);
    for (int i = 0; i < bridge_rounds && !piece.is_final; ++i) {
        piece.is_final = !split_bridges(piece.triangles);
        if (!piece.is_final) piece.triangles = triangles_from(triangle);
    }
    std::vector<int> local(at(mesh_.triangle_count()), -1);
    for (std::size_t i = 0; i < piece.triangles.size(); ++i) local[at(piece.triangles[i])] = int(i);
    auto& points = piece.corners;
    points.assign(piece.triangles.size(), {-1, -1, -1});
    std::vector<std::array<char, 3>> walked(piece.triangles.size(), {0, 0, 0});
    for (std::size_t i = 0; i < points.size(); ++i) {
        const int t = piece.triangles[i];
        piece.area += 0.5 * mesh_.area_vector(t).norm();
        for (std::size_t k = 0; k < 3; ++k)
            if (beyond_[at(t)][k] < 0 && walked[i][k] == 0)
                walk_border(piece, local, t, int(k), walked);
    }
    std::vector<int> inner(at(mesh_.vertex_count()), -1);
    int edges = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (points[i][k] >= 0) continue;
            const int v = mesh_.triangle(piece.triangles[i])[k];
            if (inner[at(v)] < 0) {
                inner[at(v)] = int(piece.vertices.size());
                piece.vertices.push_back(v);
                piece.has_apex = piece.has_apex || mesh_.corner(v) >= 0;
            }
            points[i][k] = inner[at(v)];
        }
    }
    piece.neighbours.resize(piece.vertices.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const int t = piece.triangles[i];
        const auto& c = mesh_.triangle(t);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3;
            const int beyond = beyond_[at(t)][k];
            if (beyond >= 0 && local[at(beyond)] < int(i)) continue;  // seen from there
            ++edges;
            if (beyond < 0) continue;
            const int a = points[i][k], b = points[i][l];
            const double length = (mesh_.point(c[k]) - mesh_.point(c[l])).norm();
            piece.neighbours[at(a)].emplace_back(b, length);
            piece.neighbours[at(b)].emplace_back(a, length);
        }
    }
    piece.euler = int(piece.vertices.size()) - edges + int(piece.triangles.size());
    return piece;
}

void PieceMesh::cut(const CutPiece& piece, const PiecePath& path, const Parting& start,
                    const Parting& end) {
    std::vector<int> vertices;
    for (const int i : path) vertices.push_back(piece.vertices[at(i)]);
    for (std::size_t i = 0; i + 1 < vertices.size(); ++i) add_wall(vertices[i], vertices[i + 1]);
    const auto part = [&](int point, int towards, const Parting& how) {
        const BorderPoint& b = piece.border_point(point);
        sectors_[{b.vertex, b.next}] = {how.angle, how.faces};
        sectors_[{b.vertex, towards}] = {b.angle - how.angle, how.faces_after};
        make_node(b.vertex);
    };
    part(path.front(), vertices[1], start);
    part(path.back(), vertices[vertices.size() - 2], end);
    cuts_.push_back(std::move(vertices));
}

void PieceMesh::smooth_cuts(Poll& poll) {
    std::vector<std::vector<int>> next(at(mesh_.vertex_count()));
    std::vector<char> held(next.size(), 0);
    for (const auto& [a, b] : walls_.sorted()) {
        const geom::EdgeSides s = mesh_.sides(a, b);
        if (s.triangle[1] < 0 || mesh_.curve(s.triangle[0], s.side[0]) >= 0)
            held[at(a)] = held[at(b)] = 1;
    }
    for (const auto& path : cuts_) {
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
            next[at(path[i])].push_back(path[i + 1]);
            next[at(path[i + 1])].push_back(path[i]);
        }
    }
    std::vector<int> moving;
    std::vector<Vec3> normals(next.size(), Vec3::Zero());
    for (int v = 0; v < mesh_.vertex_count(); ++v) {
        if (!mesh_.vertex_alive(v) || held[at(v)] != 0 || mesh_.corner(v) >= 0) continue;
        moving.push_back(v);
        if (next[at(v)].empty()) next[at(v)] = mesh_.neighbours(v);
        normals[at(v)] = mesh_.vertex_normal(v);
    }
    for (int round = 1; round <= smoothing_rounds; ++round) {
        poll();
        for (const int v : moving) {
            Vec3 sum = Vec3::Zero();
            for (const int w : next[at(v)]) sum += mesh_.point(w);
            mesh_.move(v, sum / double(next[at(v)].size()));
        }
        if (round % project_every != 0) continue;
        for (const int v : moving) {
            poll();
            const geom::FootPoint foot = reference_.foot_point(mesh_.point(v), normals[at(v)]);
            mesh_.move(v, foot.point);
            if (foot.normal.norm() > 0.5) normals[at(v)] = foot.normal;
        }
    }
}

}  // namespace patchwright::cage
