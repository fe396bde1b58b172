#include "cage/remesh/polygon_mesh.h"

#include "cage/remesh/quad_shape.h"
#include "geom/angle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace patchwright::cage {

namespace {

std::pair<int, int> edge_key(int a, int b) { return std::minmax(a, b); }

}  // namespace

PolygonMesh::PolygonMesh(Polygons polygons, geom::EditableMesh& mesh)
    : polygons_(std::move(polygons)), mesh_(mesh), at_vertex_(std::size_t(mesh.vertex_count())) {
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        kinds_.push_back(mesh.kind(v));
        boundary_.push_back(mesh.is_boundary(v));
    }
    for (int i = 0; i < count(); ++i) attach(i);
}

Polygons PolygonMesh::polygons() const {
    Polygons kept;
    for (int i = 0; i < count(); ++i) {
        if (corners(i).empty()) continue;
        kept.corners.push_back(corners(i));
        kept.faces.push_back(polygons_.faces[std::size_t(i)]);
    }
    return kept;
}

const std::vector<int>& PolygonMesh::of_edge(int a, int b) const {
    static const std::vector<int> none;
    const auto edge = of_edge_.find(edge_key(a, b));
    return edge == of_edge_.end() ? none : edge->second;
}

bool PolygonMesh::is_feature(int a, int b) const {
    return kind(a) != geom::VertexKind::Smooth && kind(b) != geom::VertexKind::Smooth &&
           mesh_.is_feature(a, b);
}

std::array<int, 2> PolygonMesh::neighbours_in(int polygon, int v) const {
    const auto& c = corners(polygon);
    const std::size_t k = std::size_t(std::find(c.begin(), c.end(), v) - c.begin());
    return {c[(k + 1) % c.size()], c[(k + c.size() - 1) % c.size()]};
}

double PolygonMesh::quality(int polygon) const {
    const auto& c = corners(polygon);
    const auto p = [&](std::size_t k) { return mesh_.point(c[k]); };
    return c.size() == 4 ? quad_quality({p(0), p(1), p(2), p(3)})
                         : triangle_quality({p(0), p(1), p(2)});
}

double PolygonMesh::edge_ratio(int polygon) const {
    const auto& c = corners(polygon);
    double shortest = std::numeric_limits<double>::infinity(), longest = 0.0;
    for (std::size_t k = 0; k < c.size(); ++k) {
        const double here = (mesh_.point(c[(k + 1) % c.size()]) - mesh_.point(c[k])).norm();
        shortest = std::min(shortest, here);
        longest = std::max(longest, here);
    }
    return longest > 0.0 ? shortest / longest : 0.0;
}

geom::Vec3 PolygonMesh::normal(int polygon) const {
    const auto& c = corners(polygon);
    // Of the diagonals of a quad, or of two sides of a triangle.
    const geom::Vec3 one = mesh_.point(c[2]) - mesh_.point(c[0]);
    return one.cross(mesh_.point(c.back()) - mesh_.point(c[1])).normalized();
}

double PolygonMesh::cosine_to_neighbours(int polygon) const {
    const auto& c = corners(polygon);
    const geom::Vec3 here = normal(polygon);
    double least = 1.0;
    for (std::size_t k = 0; k < c.size(); ++k) {
        const int a = c[k], b = c[(k + 1) % c.size()];
        if (is_feature(a, b)) continue;
        for (const int other : of_edge(a, b))
            if (other != polygon) least = std::min(least, here.dot(normal(other)));
    }
    return least;
}

void PolygonMesh::attach(int polygon) {
    const auto& c = corners(polygon);
    for (std::size_t k = 0; k < c.size(); ++k) {
        of_edge_[edge_key(c[k], c[(k + 1) % c.size()])].push_back(polygon);
        at_vertex_[std::size_t(c[k])].push_back(polygon);
    }
}

void PolygonMesh::detach(int polygon) {
    const auto& c = corners(polygon);
    for (std::size_t k = 0; k < c.size(); ++k) {
        const auto edge = of_edge_.find(edge_key(c[k], c[(k + 1) % c.size()]));
        std::erase(edge->second, polygon);
        if (edge->second.empty()) of_edge_.erase(edge);
        std::erase(at_vertex_[std::size_t(c[k])], polygon);
    }
}

void PolygonMesh::replace(int polygon, std::vector<int> corners) {
    detach(polygon);
    polygons_.corners[std::size_t(polygon)] = std::move(corners);
    attach(polygon);
}

int PolygonMesh::add(std::vector<int> corners, int like) {
    polygons_.corners.push_back(std::move(corners));
    polygons_.faces.push_back(polygons_.faces[std::size_t(like)]);
    attach(count() - 1);
    return count() - 1;
}

int PolygonMesh::add_vertex(const geom::Vec3& p) {
    at_vertex_.emplace_back();
    kinds_.push_back(geom::VertexKind::Smooth);
    boundary_.push_back(false);
    return mesh_.add_vertex(p);
}

int PolygonMesh::split_feature(int a, int b, const geom::Vec3& p) {
    const std::vector<int> beside = of_edge(a, b);
    const int middle = mesh_.split(a, b, p);
    at_vertex_.emplace_back();
    kinds_.push_back(mesh_.kind(middle));
    boundary_.push_back(mesh_.is_boundary(middle));
    for (const int polygon : beside) {
        std::vector<int> c = corners(polygon);
        const std::size_t k = std::size_t(std::find(c.begin(), c.end(), a) - c.begin());
        const bool from_a = c[(k + 1) % c.size()] == b;
        c.insert(c.begin() + std::ptrdiff_t(from_a ? k + 1 : k), middle);
        replace(polygon, std::move(c));
    }
    return middle;
}

bool PolygonMesh::shares_edges_only(int polygon) const {
    const auto& c = corners(polygon);
    for (std::size_t k = 0; k < c.size(); ++k)
        if (of_edge(c[k], c[(k + 1) % c.size()]).size() > 2) return false;
    std::map<int, int> common;
    for (const int v : c)
        for (const int other : at_vertex(v))
            if (other != polygon && ++common[other] > 2) return false;
    return true;
}

double PolygonMesh::angle_at(int polygon, int v) const {
    const auto [next, last] = neighbours_in(polygon, v);
    return geom::angle_between(mesh_.point(next) - mesh_.point(v),
                               mesh_.point(last) - mesh_.point(v));
}

std::vector<std::vector<int>> PolygonMesh::sectors(int v) const {
    if (kind(v) == geom::VertexKind::Smooth) return {at_vertex(v)};
    std::vector<std::vector<int>> result;
    std::vector<int> left = at_vertex(v);
    while (!left.empty()) {
        std::vector<int> sector{left.back()};
        left.pop_back();
        for (std::size_t i = 0; i < sector.size(); ++i)
            for (const int w : neighbours_in(sector[i], v)) {
                if (is_feature(v, w)) continue;
                for (const int other : of_edge(v, w)) {
                    const auto next = std::find(left.begin(), left.end(), other);
                    if (next == left.end()) continue;
                    sector.push_back(other);
                    left.erase(next);
                }
            }
        result.push_back(std::move(sector));
    }
    return result;
}

std::vector<int> PolygonMesh::regions() const {
    std::vector<int> region(std::size_t(count()), -1);
    int regions = 0;
    for (int start = 0; start < count(); ++start) {
        if (region[std::size_t(start)] >= 0 || corners(start).empty()) continue;
        std::vector<int> pending{start};
        region[std::size_t(start)] = regions;
        while (!pending.empty()) {
            const auto& c = corners(pending.back());
            pending.pop_back();
            for (std::size_t k = 0; k < c.size(); ++k) {
                const int a = c[k], b = c[(k + 1) % c.size()];
                if (is_feature(a, b)) continue;
                for (const int other : of_edge(a, b)) {
                    if (region[std::size_t(other)] >= 0) continue;
                    region[std::size_t(other)] = regions;
                    pending.push_back(other);
                }
            }
        }
        ++regions;
    }
    return region;
}

int PolygonMesh::flaws(int v, const std::vector<int>& sector) const {
    double angle = 0.0, widest = 0.0;
    if (kind(v) == geom::VertexKind::Fixed)
        for (const int polygon : sector) {
            const double here = angle_at(polygon, v);
            angle += here;
            widest = std::max(widest, here);
        }
    const int missing = least_faces(kind(v), is_boundary(v), angle) - int(sector.size());
    return std::max(missing, 0) + (is_even_enough(kind(v), widest, angle) ? 0 : 1);
}

int PolygonMesh::flaws(int v) const {
    const int faces = int(at_vertex(v).size());
    int sum = std::max((is_boundary(v) ? 1 : 3) - faces, 0);
    if (faces > 0)
        for (const std::vector<int>& sector : sectors(v)) sum += flaws(v, sector);
    return sum;
}

int PolygonMesh::regular_faces(int v, const std::vector<int>& sector) const {
    if (kind(v) == geom::VertexKind::Curve) return 2;
    if (kind(v) == geom::VertexKind::Smooth) return is_boundary(v) ? 2 : 4;
    double angle = 0.0;
    for (const int polygon : sector) angle += angle_at(polygon, v);
    return std::max(int(std::lround(angle / (0.5 * std::numbers::pi))),
                    least_faces(kind(v), is_boundary(v), angle));
}

int PolygonMesh::irregularity(int v) const {
    int sum = 0;
    for (const std::vector<int>& sector : sectors(v)) {
        const int off = int(sector.size()) - regular_faces(v, sector);
        sum += off * off;
    }
    return sum;
}

}  // namespace patchwright::cage
