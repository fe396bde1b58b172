#include "cage/remesh/remesh.h"

#include "cage/remesh/curve_ways.h"
#include "cage/remesh/quad_shape.h"
#include "cage/remesh/sectors.h"
#include "geom/angle.h"

#include <patchwright/geom/nearest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Cosines of angles by which triangles may turn: parts of a split one against the whole (73
// degrees), and any triangle by a collapse, a flip or a moved vertex (60 degrees). More is taken
// for a fold.
constexpr double least_alike = 0.3, unturned = 0.5;
// Of the length wanted: how far a collapse may leave the point that goes, and a flip the edge.
// More, and step by step a thin edge is eaten.
constexpr double most_lost = 0.25;
// Of the tolerance: triangles that are smaller do not keep others from collapsing, as across a thin
// rounded edge, wherever they face.
constexpr double negligible_share = 0.25;
// Of the length wanted: edges that are longer are split, shorter ones collapsed. Of both factors
// the one makes halves, the other merged edges that are nearest to the length (Botsch and Kobbelt).
constexpr double too_long = 4.0 / 3.0, too_short = 0.8;
// Passes until nothing changes, at most. Splits halve lengths: 12 passes make up for 2^12.
constexpr int split_passes = 12, collapse_passes = 6, flip_passes = 5;
// Sum of the two angles across an edge, above pi, from which on it is flipped (Delaunay). The
// margin keeps edges of squares from flipping to and fro.
constexpr double flip_angle_rad = 1.02 * M_PI;
// Share of the way to the middle of its neighbours that a vertex is moved in a round.
constexpr double relaxation = 0.7;

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 normal = (b - a).cross(c - a);
    const double area = normal.squaredNorm();
    const std::array<Vec3, 3> corner{a, b, c};
    bool inside = area > 0.0;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &from = corner[k], side = corner[(k + 1) % 3] - from;
        if (normal.dot(side.cross(p - from)) < 0.0) inside = false;
        const Vec3 at = geom::nearest_on_segment(p, from, corner[(k + 1) % 3]).point;
        nearest = std::min(nearest, (p - at).norm());
    }
    return inside ? std::abs(normal.dot(p - a)) / std::sqrt(area) : nearest;
}

class Remeshing {
  public:
    Remeshing(geom::EditableMesh& mesh, const geom::ModelSurface& reference,
              const RemeshOptions& options, Poll& poll)
        : mesh_(mesh),
          reference_(reference),
          options_(options),
          ways_(reference, poll),
          poll_(poll),
          size_(mesh, reference, options.size, poll),
          negligible_(negligible_share * options.size.tolerance_rel * reference.size()) {}

    void run() {
        for (int round = 0; round < options_.rounds; ++round) {
            poll_.reached(double(round) / options_.rounds);
            split_long();
            size_.limit_growth();
            collapse_short();
            flip_all();
            relax_all();
        }
        collapse_short();
        flip_all();
        relax_all();
        open_corners();
    }

  private:
    [[nodiscard]] double length(int a, int b) const {
        return (mesh_.point(a) - mesh_.point(b)).norm();
    }
    [[nodiscard]] double wanted(int a, int b) const { return std::min(size_.at(a), size_.at(b)); }

    [[nodiscard]] Vec3 on_surface(const Vec3& p, const Vec3& normal) const {
        poll_();
        const double norm = normal.norm();
        if (!(norm > 0.5)) return reference_.foot_point(p).point;
        return reference_.foot_point(p, Vec3(normal / norm)).point;
    }

    [[nodiscard]] Vec3 middle(int a, int b) const {
        const Vec3 chord = 0.5 * (mesh_.point(a) + mesh_.point(b));
        const geom::EdgeSides s = mesh_.sides(a, b);
        const int curve = mesh_.curve(s.triangle[0], s.side[0]);
        const double reach = 0.5 * length(a, b);
        Vec3 p = chord;
        if (curve >= 0) {
            p = ways_.middle(curve, mesh_.point(a), mesh_.point(b));
        } else {
            Vec3 normal = Vec3::Zero();
            for (const int t : s.triangle)
                if (t >= 0) normal += mesh_.area_vector(t);
            p = on_surface(chord, normal.normalized());
        }
        return (p - chord).norm() < reach && parts_face_alike(a, b, s, p) ? p : chord;
    }

    /// Whether the parts of the triangles at an edge face as those do, when it is split at p: where
    /// the nearest point is on another sheet of the model they do not, and splitting would not end.
    [[nodiscard]] bool parts_face_alike(int a, int b, const geom::EdgeSides& s,
                                        const Vec3& p) const {
        for (std::size_t i = 0; i < 2; ++i) {
            if (s.triangle[i] < 0) continue;
            const auto& c = mesh_.triangle(s.triangle[i]);
            const int other = c[std::size_t((s.side[i] + 2) % 3)];
            const int from = c[std::size_t(s.side[i])], to = from == a ? b : a;
            const Vec3 whole = mesh_.area_vector(s.triangle[i]), &q = mesh_.point(other);
            const Vec3 one = (p - mesh_.point(from)).cross(q - mesh_.point(from));
            const Vec3 two = (mesh_.point(to) - p).cross(q - p);
            if (one.dot(whole) < least_alike * one.norm() * whole.norm() ||
                two.dot(whole) < least_alike * two.norm() * whole.norm())
                return false;
        }
        return true;
    }

    void split_long() {
        for (int pass = 0; pass < split_passes; ++pass) {
            bool any = false;
            const int count = mesh_.triangle_count();
            for (int t = 0; t < count; ++t) {
                if (!mesh_.alive(t)) continue;
                // Longest side first: its triangles come out best.
                int longest = 0;
                double ratio = 0.0;
                for (int k = 0; k < 3; ++k) {
                    const auto& c = mesh_.triangle(t);
                    const int a = c[std::size_t(k)], b = c[std::size_t((k + 1) % 3)];
                    const double r = length(a, b) / wanted(a, b);
                    if (r > ratio) {
                        ratio = r;
                        longest = k;
                    }
                }
                if (ratio <= too_long) continue;
                const int a = mesh_.triangle(t)[std::size_t(longest)];
                const int b = mesh_.triangle(t)[std::size_t((longest + 1) % 3)];
                mesh_.split(a, b, middle(a, b));
                size_.add_vertex(a, b);
                any = true;
            }
            flip_all();
            if (!any) return;
        }
    }

    /// How far the point that goes is from the triangles that are there afterwards.
    [[nodiscard]] double lost_by_collapse(int gone, int kept) const {
        const Vec3& p = mesh_.point(gone);
        double nearest = std::numeric_limits<double>::infinity();
        for (const int t : mesh_.fan(gone)) {
            const auto& c = mesh_.triangle(t);
            if (c[0] == kept || c[1] == kept || c[2] == kept) continue;
            const auto at = [&](std::size_t k) { return mesh_.point(c[k] == gone ? kept : c[k]); };
            nearest = std::min(nearest, distance_to_triangle(p, at(0), at(1), at(2)));
        }
        return nearest;
    }

    bool try_collapse(int gone, int kept) {
        if (!mesh_.can_collapse(gone, kept) ||
            !mesh_.collapse_is_flat(gone, kept, unturned, negligible_))
            return false;
        for (const int w : mesh_.neighbours(gone))
            if (w != kept && length(w, kept) > too_long * wanted(w, kept) &&
                length(w, kept) > length(w, gone))
                return false;
        if (lost_by_collapse(gone, kept) > most_lost * size_.at(gone)) return false;
        mesh_.collapse(gone, kept);
        return true;
    }

    void collapse_short() {
        for (int pass = 0; pass < collapse_passes; ++pass) {
            std::vector<std::pair<double, std::pair<int, int>>> edges;
            for (int t = 0; t < mesh_.triangle_count(); ++t) {
                if (!mesh_.alive(t)) continue;
                for (std::size_t k = 0; k < 3; ++k) {
                    const int a = mesh_.triangle(t)[k], b = mesh_.triangle(t)[(k + 1) % 3];
                    const double ratio = length(a, b) / wanted(a, b);
                    if (ratio < too_short && (a < b || mesh_.sides(a, b).triangle[1] < 0))
                        edges.emplace_back(ratio, std::pair(a, b));
                }
            }
            std::sort(edges.begin(), edges.end());
            bool any = false;
            for (const auto& [ratio, edge] : edges) {
                const auto [a, b] = edge;
                poll_();
                if (!mesh_.vertex_alive(a) || !mesh_.vertex_alive(b)) continue;
                if (mesh_.sides(a, b).triangle[0] < 0) continue;
                if (length(a, b) >= too_short * wanted(a, b)) continue;
                any = try_collapse(a, b) || try_collapse(b, a) || any;
            }
            if (!any) return;
        }
    }

    /// Flips to the triangles whose least angles are larger and that bend no more.
    bool try_flip(int a, int b) {
        const geom::EdgeSides s = mesh_.sides(a, b);
        if (s.triangle[1] < 0) return false;
        const int c = mesh_.triangle(s.triangle[0])[std::size_t((s.side[0] + 2) % 3)];
        const int d = mesh_.triangle(s.triangle[1])[std::size_t((s.side[1] + 2) % 3)];
        const Vec3 &pa = mesh_.point(a), &pb = mesh_.point(b), &pc = mesh_.point(c),
                   &pd = mesh_.point(d);
        // Most edges by far are good ones, so what is cheap is asked first: the sine of both
        // angles' sum is negative beyond pi.
        const Vec3 ca = pa - pc, cb = pb - pc, da = pa - pd, db = pb - pd;
        if (ca.cross(cb).norm() * da.dot(db) + da.cross(db).norm() * ca.dot(cb) > 0.0) return false;
        if (geom::angle_between(ca, cb) + geom::angle_between(da, db) < flip_angle_rad)
            return false;
        if (!mesh_.can_flip(a, b)) return false;
        // Orientation: from, to of the first triangle.
        const int from = mesh_.triangle(s.triangle[0])[std::size_t(s.side[0])];
        const Vec3 &pf = mesh_.point(from), &pt = mesh_.point(from == a ? b : a);
        const Vec3 before =
            (mesh_.area_vector(s.triangle[0]) + mesh_.area_vector(s.triangle[1])).normalized();
        const Vec3 one = (pf - pc).cross(pd - pc), two = (pt - pd).cross(pc - pd);
        if (one.dot(before) < unturned * one.norm() || two.dot(before) < unturned * two.norm())
            return false;
        if (one.norm() == 0.0 || two.norm() == 0.0) return false;
        const Vec3 across = (pb - pa).cross(pd - pc);
        if (std::abs(across.dot(pc - pa)) > most_lost * wanted(a, b) * across.norm()) return false;
        mesh_.flip(a, b);
        return true;
    }

    void flip_all() {
        for (int pass = 0; pass < flip_passes; ++pass) {
            bool any = false;
            for (int t = 0; t < mesh_.triangle_count(); ++t) {
                poll_();
                for (std::size_t k = 0; k < 3 && mesh_.alive(t); ++k) {
                    const int a = mesh_.triangle(t)[k], b = mesh_.triangle(t)[(k + 1) % 3];
                    any = try_flip(a, b) || any;
                }
            }
            if (!any) return;
        }
    }

    /// Divides triangles at feature curves and corners where the faces between two features would
    /// be too few or too wide for the limit surface, across the side that faces the vertex.
    void open_corners() {
        const Sectors sectors = sectors_of(mesh_);
        std::vector<int> added(sectors.sectors.size(), 0);
        const int count = mesh_.triangle_count();
        for (int t = 0; t < count; ++t) {
            const std::array<int, 3> c = mesh_.triangle(t);
            for (int k = 0; k < 3 && mesh_.alive(t) && mesh_.triangle(t) == c; ++k) {
                const int tip = c[std::size_t(k)], a = c[std::size_t((k + 1) % 3)],
                          b = c[std::size_t((k + 2) % 3)];
                const int number = sectors.of_corner[std::size_t(t)][std::size_t(k)];
                const FaceSector& sector = sectors.sectors[std::size_t(number)];
                const double angle = mesh_.corner_angle(t, k);
                const bool few = sector.faces + added[std::size_t(number)] < sector.least &&
                                 angle * sector.faces >= sector.angle_rad;
                if (mesh_.kind(tip) == geom::VertexKind::Smooth ||
                    mesh_.sides(a, b).triangle[1] < 0)
                    continue;
                if (!few && is_even_enough(mesh_.kind(tip), angle, sector.angle_rad)) continue;
                mesh_.split(a, b, middle(a, b));
                size_.add_vertex(a, b);
                ++added[std::size_t(number)];
            }
        }
    }

    [[nodiscard]] bool stays_oriented(int v, const Vec3& to) const {
        for (const int t : mesh_.fan(v)) {
            std::array<Vec3, 3> p;
            for (std::size_t k = 0; k < 3; ++k) {
                const int w = mesh_.triangle(t)[k];
                p[k] = w == v ? to : mesh_.point(w);
            }
            const Vec3 after = (p[1] - p[0]).cross(p[2] - p[0]);
            const Vec3 before = mesh_.area_vector(t);
            if (after.dot(before) <= unturned * after.norm() * before.norm()) return false;
        }
        return true;
    }

    [[nodiscard]] std::optional<Vec3> relaxed(int v) const {
        const geom::VertexKind kind = mesh_.kind(v);
        if (kind == geom::VertexKind::Fixed) return std::nullopt;
        if (kind == geom::VertexKind::Curve) {
            const auto next = mesh_.feature_neighbours(v);
            // Ways to both sides in the ratio of the sizes wanted there.
            const double s0 = size_.at(next[0]), s1 = size_.at(next[1]);
            const int curve = mesh_.curve_at(v);
            const double here = ways_.arc_at(curve, mesh_.point(v));
            const double a = ways_.way(curve, here, ways_.arc_at(curve, mesh_.point(next[0])));
            const double b = ways_.way(curve, here, ways_.arc_at(curve, mesh_.point(next[1])));
            if (!(a * b < 0.0)) return std::nullopt;
            return reference_.point_on_curve(curve, here + (s1 * a + s0 * b) / (s0 + s1)).point;
        }
        Vec3 sum = Vec3::Zero();
        double weight = 0.0;
        for (const int t : mesh_.fan(v)) {
            const auto& c = mesh_.triangle(t);
            double size = 0.0;
            for (const int w : c) size += size_.at(w) / 3.0;
            const double part = mesh_.area_vector(t).norm() / (size * size);
            sum += part * (mesh_.point(c[0]) + mesh_.point(c[1]) + mesh_.point(c[2])) / 3.0;
            weight += part;
        }
        if (!(weight > 0.0)) return std::nullopt;
        const Vec3 normal = mesh_.vertex_normal(v);
        Vec3 shift = sum / weight - mesh_.point(v);
        shift -= normal.dot(shift) * normal;
        return on_surface(mesh_.point(v) + relaxation * shift, normal);
    }

    void relax_all() {
        for (int v = 0; v < mesh_.vertex_count(); ++v) {
            if (!mesh_.vertex_alive(v)) continue;
            const auto to = relaxed(v);
            if (to && stays_oriented(v, *to)) mesh_.move(v, *to);
        }
    }

    geom::EditableMesh& mesh_;
    const geom::ModelSurface& reference_;
    const RemeshOptions& options_;
    CurveWays ways_;
    Poll& poll_;
    SizeField size_;
    double negligible_;  // millimetres
};

}  // namespace

void remesh(geom::EditableMesh& mesh, const geom::ModelSurface& reference,
            const RemeshOptions& options, Poll& poll) {
    Remeshing(mesh, reference, options, poll).run();
}

}  // namespace patchwright::cage
