#include "cage/blocks/wide_corners.h"

#include "cage/blocks/folded_quads.h"

#include <patchwright/base/numbers.h>
#include <patchwright/mesh/chords.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace patchwright::cage {

using base::at;
using geom::Vec3;
using mesh::CornerId;
using mesh::Topology;

namespace {

Topology topology_of(const Blocks& blocks) {
    mesh::TopologyInput input;
    add_to(input, blocks);
    return Topology(input);
}

/// Two quads between features at a corner.
struct QuadPair {
    CornerId first, inner, last;  ///< half-edges: the outer ones are on features, `last` ends here
};

std::vector<QuadPair> quad_pairs_at_corners(const Topology& t) {
    const auto is_feature = [&](CornerId c) { return std::isinf(t.sharpness(t.edge(c))); };
    std::vector<QuadPair> pairs;
    for (const mesh::FaceId f : t.faces())
        for (const CornerId c : t.corners(f)) {
            if (t.tagged_sharpness(t.vertex(c)) == 0.0 || !is_feature(c)) continue;
            const CornerId inner = t.rotate(c);
            if (!inner.valid() || is_feature(inner) || !is_feature(t.previous(inner))) continue;
            pairs.push_back({c, inner, t.previous(inner)});
        }
    return pairs;
}

/// How far beyond a corner the ends of edges from it go in subdivision steps (decision 056).
double beyond_corner(const Vec3& d1, const Vec3& e, const Vec3& d2) {
    constexpr int most_steps = 30;  // a metre is a nanometre then
    const Vec3 outwards = (d1.normalized() + d2.normalized()).normalized();
    if (e.dot(outwards) >= 0.0) return 0.0;  // the two quads span less than half a turn
    double most = 0.0;
    for (int k = 1; k <= most_steps; ++k)
        most = std::max(most, std::ldexp((e + k / 6.0 * (d1 + d2)).dot(outwards), -k));
    return most;
}

std::vector<char> chords_to_split(const Topology& t, const mesh::Chords& chords,
                                  const std::vector<Vec3>& points, double allowed_mm) {
    const auto chord = [&](CornerId c) { return chords.of_edge[t.edge(c).index()]; };
    const auto way = [&](CornerId from, CornerId to) {
        return Vec3(points[t.vertex(to).index()] - points[t.vertex(from).index()]);
    };
    std::set<std::pair<int, int>> wanted;  // and the chord that is to stay
    for (const QuadPair& pair : quad_pairs_at_corners(t)) {
        const Vec3 d1 = way(pair.first, t.next(pair.first)), d2 = way(pair.inner, pair.last);
        if (beyond_corner(d1, way(pair.inner, t.next(pair.inner)), d2) <= allowed_mm) continue;
        if (2.0 * d1.norm() >= d2.norm()) wanted.emplace(chord(pair.first), chord(pair.inner));
        if (2.0 * d2.norm() >= d1.norm()) wanted.emplace(chord(pair.last), chord(pair.inner));
    }
    std::set<int> to_stay;
    for (const auto& [split, stays] : wanted) to_stay.insert(stays);
    std::vector<char> chosen(at(chords.count), 0);
    for (const auto& [split, stays] : wanted) chosen[at(split)] = to_stay.contains(split) ? 0 : 1;
    return chosen;
}

/// Points of new vertices, on the model.
class NewPoints {
  public:
    NewPoints(Blocks& blocks, EdgeCurves& curves, const geom::ModelSurface& reference)
        : blocks_(blocks), curves_(curves), reference_(reference) {}

    void add(const mesh::ChordSplit::Origin& origin) {
        const std::vector<int>& face = blocks_.faces[origin.face.index()];
        if (origin.u == 0.5 && origin.v == 0.5) {
            add_on_surface(origin.face, quad_middle(blocks_, origin.face.index()));
            return;
        }
        const std::size_t side =
            origin.u == 0.5 ? (origin.v == 0.0 ? 0 : 2) : (origin.u == 1.0 ? 1 : 3);
        const int a = face[side], b = face[(side + 1) % 4];
        const Vec3 middle = 0.5 * (blocks_.points[at(a)] + blocks_.points[at(b)]);
        const auto curve = curves_.find(std::minmax(a, b));
        if (curve == curves_.end()) {
            add_on_surface(origin.face, middle);
            return;
        }
        const int on = curve->second, v = int(blocks_.points.size());
        blocks_.points.push_back(reference_.nearest_on_curve(on, middle).point);
        curves_[std::minmax(a, v)] = curves_[std::minmax(v, b)] = on;
    }

  private:
    void add_on_surface(mesh::FaceId face, const Vec3& near) {
        const Vec3 normal = quad_area(blocks_, face.index()).normalized();
        blocks_.points.push_back(reference_.foot_point(near, normal).point);
    }

    Blocks& blocks_;
    EdgeCurves& curves_;
    const geom::ModelSurface& reference_;
};

}  // namespace

void divide_at_wide_corners(Blocks& blocks, EdgeCurves curves, const geom::ModelSurface& reference,
                            double allowed_mm, Poll& poll) {
    for (;;) {
        poll();
        const Topology t = topology_of(blocks);
        const mesh::Chords chords = mesh::find_chords(t);
        const std::vector<char> chosen = chords_to_split(t, chords, blocks.points, allowed_mm);
        if (std::ranges::find(chosen, 1) == chosen.end()) return;
        const mesh::ChordSplit fine = mesh::split_chords(t, chords, chosen);
        NewPoints points(blocks, curves, reference);
        for (std::size_t v = blocks.points.size(); v < fine.vertices.size(); ++v)
            points.add(fine.vertices[v]);
        blocks.faces.clear();
        blocks.creases.clear();
        for (const mesh::FaceId f : fine.topology->faces()) {
            blocks.faces.emplace_back();
            for (const CornerId c : fine.topology->corners(f))
                blocks.faces.back().push_back(fine.topology->vertex(c).value);
        }
        for (const mesh::EdgeId e : fine.topology->edges())
            if (fine.topology->tagged_sharpness(e) > 0.0)
                blocks.creases.emplace_back(fine.topology->start(e).value,
                                            fine.topology->end(e).value);
    }
}

}  // namespace patchwright::cage
