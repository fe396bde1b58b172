#include "cage/sections/sections.h"

#include "geom/disjoint_sets.h"
#include "geom/polyline.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace patchwright::cage {

using geom::Vec3;

std::vector<SurfaceBody> bodies_of(const geom::SurfaceMesh& mesh) {
    geom::DisjointSets connected(std::size_t(mesh.points.rows()));
    for (const auto& t : mesh.triangles)
        for (const int v : {t[1], t[2]}) connected.join(t[0], v);
    std::map<int, SurfaceBody> bodies;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        SurfaceBody& body = bodies[connected.find(mesh.triangles[t][0])];
        body.mesh = &mesh;
        body.triangles.push_back(int(t));
    }
    std::vector<SurfaceBody> result;
    for (auto& [root, body] : bodies) result.push_back(std::move(body));
    return result;
}

double SectionLoop::length() const {
    double sum = geom::length_of(points);
    if (closed && points.size() > 1) sum += (points.front() - points.back()).norm();
    return sum;
}

void SectionLoop::reverse() {
    std::reverse(points.begin(), points.end());
    for (Crossing& c : crossings) c.point = int(points.size()) - 1 - c.point;
}

std::vector<SectionLoop> rims(const SurfaceBody& body) {
    const geom::SurfaceMesh& mesh = *body.mesh;
    std::map<std::pair<int, int>, int> uses;
    for (const int t : body.triangles) {
        const auto& c = mesh.triangles[std::size_t(t)];
        for (std::size_t k = 0; k < 3; ++k) ++uses[std::minmax(c[k], c[(k + 1) % 3])];
    }
    std::map<int, int> next;
    for (const int t : body.triangles) {
        const auto& c = mesh.triangles[std::size_t(t)];
        for (std::size_t k = 0; k < 3; ++k)
            if (uses[std::minmax(c[k], c[(k + 1) % 3])] == 1) next[c[k]] = c[(k + 1) % 3];
    }
    std::map<int, std::set<int>> reached;
    for (const geom::FeatureSide& f : mesh.features) {
        const auto use = uses.find({f.v0, f.v1});
        if (use == uses.end() || use->second == 1) continue;
        for (const int v : {f.v0, f.v1})
            if (next.contains(v)) reached[v].insert(f.curve);
    }
    std::vector<SectionLoop> loops;
    while (!next.empty()) {
        std::vector<int> line{next.begin()->first};
        for (auto step = next.begin(); step != next.end(); step = next.find(line.back())) {
            line.push_back(step->second);
            next.erase(step);
        }
        SectionLoop loop;
        loop.closed = line.front() == line.back();
        if (loop.closed) line.pop_back();
        for (const int v : line) {
            for (const int curve : reached[v])
                loop.crossings.push_back({int(loop.points.size()), curve});
            loop.points.push_back(mesh.points.row(v));
        }
        loops.push_back(std::move(loop));
    }
    return loops;
}

Slicer::Slicer(const SurfaceBody& body, Spine spine) : body_(&body), spine_(std::move(spine)) {
    const geom::Points& points = body.mesh->points;
    heights_.resize(std::size_t(points.rows()));
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        heights_[std::size_t(i)] = spine_.height(points.row(i));
    mine_.assign(heights_.size(), 0);
    low_ = std::numeric_limits<double>::infinity();
    high_ = -low_;
    for (const int t : body.triangles) {
        for (const int v : body.mesh->triangles[std::size_t(t)]) {
            mine_[std::size_t(v)] = 1;
            low_ = std::min(low_, heights_[std::size_t(v)]);
            high_ = std::max(high_, heights_[std::size_t(v)]);
        }
    }
}

std::vector<SectionLoop> Slicer::cut(double height) const {
    const geom::SurfaceMesh& mesh = *body_->mesh;
    using Side = std::pair<int, int>;
    const auto above = [&](int v) { return heights_[std::size_t(v)] >= height; };
    const auto point_on = [&](const Side& side) {
        const Vec3 a = mesh.points.row(side.first), b = mesh.points.row(side.second);
        const double from = spine_.offset(a, height), to = spine_.offset(b, height);
        // Of a fan both may lie on one side where its planes turn; heights are what tells sides.
        const double share = from == to ? 0.5 : std::clamp(from / (from - to), 0.0, 1.0);
        return Vec3(a + share * (b - a));
    };
    std::map<Side, Side> next;
    std::set<Side> has_previous;
    for (const int t : body_->triangles) {
        const auto& c = mesh.triangles[std::size_t(t)];
        // A triangle's sides rise on the right of the line along normal x outward.
        std::optional<Side> from, to;
        for (std::size_t k = 0; k < 3; ++k) {
            const int a = c[k], b = c[(k + 1) % 3];
            if (above(a) == above(b)) continue;
            (above(b) ? to : from) = std::minmax(a, b);
        }
        if (!from) continue;
        next[*from] = *to;
        has_previous.insert(*to);
    }
    std::map<Side, int> feature;
    for (const geom::FeatureSide& f : mesh.features)
        if (next.contains({f.v0, f.v1}) || has_previous.contains({f.v0, f.v1}))
            feature[{f.v0, f.v1}] = f.curve;
    std::vector<SectionLoop> loops;
    const auto follow = [&](const Side start, bool closed) {  // not a key of what it erases
        SectionLoop loop;
        loop.closed = closed;
        Side at = start;
        for (;;) {
            const auto f = feature.find(at);
            if (f != feature.end()) loop.crossings.push_back({int(loop.points.size()), f->second});
            loop.points.push_back(point_on(at));
            const auto step = next.find(at);
            if (step == next.end()) break;
            at = step->second;
            next.erase(step);
            if (at == start) break;
        }
        loops.push_back(std::move(loop));
    };
    std::vector<Side> open;
    for (const auto& [from, to] : next)
        if (!has_previous.contains(from)) open.push_back(from);
    for (const Side& start : open) follow(start, false);
    while (!next.empty()) follow(next.begin()->first, true);
    return loops;
}

}  // namespace patchwright::cage
