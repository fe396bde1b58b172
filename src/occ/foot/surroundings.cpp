#include "occ/foot/surroundings.h"

#include "geom/angle.h"

#include <patchwright/base/numbers.h>
#include <patchwright/base/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace patchwright::occ {

using base::infinity;
using geom::Vec3;

namespace {

constexpr double widest_bend_rad = 1.0;

/// The triangles at each node.
class Fans {
  public:
    explicit Fans(const ReferenceMesh& mesh) : start_(std::size_t(mesh.nodes) + 1, 0) {
        for (const MeshTriangle& t : mesh.triangles)
            for (const int node : t.node) ++start_[std::size_t(node) + 1];
        for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
        triangles_.resize(start_.back());
        std::vector<std::size_t> fill(start_.begin(), start_.end() - 1);
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            for (const int node : mesh.triangles[i].node) triangles_[fill[std::size_t(node)]++] = i;
    }
    template <class Visit>
    void each(int node, Visit&& visit) const {
        for (auto i = start_[std::size_t(node)]; i < start_[std::size_t(node) + 1]; ++i)
            visit(triangles_[i]);
    }

  private:
    std::vector<std::size_t> start_, triangles_;
};

// Over the plane that touches the surface in the foot, the surface is a graph whose second
// derivatives are at most curvature / cos(turn)^3. Where that times the distance stays below 1, no
// other point of the graph is nearer: r^2 + (d - h)^2 >= d^2 for h <= r^2 / (2 d).
std::array<double, 2> bend_around(const ReferenceMesh& mesh, const Fans& fans,
                                  const MeshTriangle& t) {
    double out = 0.0, in = 0.0, turn = 0.0;
    for (const int node : t.node) {
        fans.each(node, [&](std::size_t i) {
            const MeshTriangle& other = mesh.triangles[i];
            out = std::max(out, other.bend_out);
            in = std::max(in, other.bend_in);
            const bool flat = other.normal.isZero(0.0) || t.normal.isZero(0.0);
            const double between = flat ? infinity : geom::angle_between(t.normal, other.normal);
            turn = std::max(turn, t.turn_rad + between + other.turn_rad);
        });
    }
    if (!(turn <= widest_bend_rad)) return {infinity, infinity};
    const double cosine = std::cos(turn);
    const double share = cosine * cosine * cosine;
    return {out / share, in / share};
}

bool is_tight(const ReferenceMesh& mesh, const Fans& fans, const MeshTriangle& t) {
    bool tight = true;
    for (const int node : t.node)
        fans.each(node, [&](std::size_t i) { tight &= !std::isinf(mesh.triangles[i].spread); });
    return tight;
}

// Centroid by centroid, in quarters where the triangle is large beside its distance.
double clearance_of(const CurveSearch& edges, const std::array<Vec3, 3>& corner, double bound,
                    int depth) {
    constexpr int max_quarterings = 3;
    constexpr double small = 0.2;
    const auto& [a, b, c] = corner;
    const Vec3 centre = (a + b + c) / 3.0;
    const double radius = std::max({(a - centre).norm(), (b - centre).norm(), (c - centre).norm()});
    const double from_centre = edges.clearance(centre, bound + radius);
    const double least = from_centre - radius;
    if (least >= bound || from_centre <= 0.0) return least;
    if (radius <= small * from_centre || depth == max_quarterings) return least;
    const Vec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    double found = std::min(bound, from_centre);
    using Corners = std::array<Vec3, 3>;
    for (const Corners& quarter :
         {Corners{a, ab, ca}, Corners{ab, b, bc}, Corners{ca, bc, c}, Corners{ab, bc, ca}}) {
        found = std::min(found, clearance_of(edges, quarter, found, depth + 1));
        if (found <= 0.0) break;
    }
    return found;
}

double clearance(const MeshTriangle& t, const FaceSurface& surface, const CurveSearch& edges) {
    const double free = clearance_of(edges, t.corner, infinity, 0);
    const bool crossed = !(free > t.error + t.overhang);
    const Vec2 middle = (t.uv[0] + t.uv[1] + t.uv[2]) / 3.0;
    return crossed || !surface.contains(middle) ? -1.0 : free;
}

}  // namespace

std::vector<Surroundings> look_around(const ReferenceMesh& mesh,
                                      const std::vector<FaceSurface>& surfaces,
                                      const CurveSearch& edges) {
    const Fans fans(mesh);
    const auto& numbers = mesh.tree.numbers();
    std::vector<Surroundings> result(numbers.size());
    base::parallel_for(numbers.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t slot = begin; slot < end; ++slot) {
            if (numbers[slot] < 0) continue;
            const MeshTriangle& t = mesh.triangles[std::size_t(numbers[slot])];
            const FaceSurface& surface = surfaces[std::size_t(t.face)];
            Surroundings& around = result[slot];
            around.node = {t.node[0], t.node[1], t.node[2]};
            if (!surface.has_kinks()) {
                const auto bend = bend_around(mesh, fans, t);
                around.bend = {std::nextafter(float(bend[0]), std::numeric_limits<float>::max()),
                               std::nextafter(float(bend[1]), std::numeric_limits<float>::max())};
            }
            around.tight = is_tight(mesh, fans, t);
            const double free = clearance(t, surface, edges);
            around.clearance =
                free > 0.0 ? std::nextafter(float(std::min(free, 1e30)), 0.0f) : -1.0f;
        }
    });
    return result;
}

}  // namespace patchwright::occ
