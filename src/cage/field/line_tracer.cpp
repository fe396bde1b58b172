#include "cage/field/line_tracer.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Sine of the least angle between a line and a side that it enters a triangle by (3 degrees): the
// field may turn back at an edge.
constexpr double least_inward = 0.05;
// Sine of the least angle, 40 degrees, at which lines may cross.
constexpr double least_crossing = 0.64;

/// The direction of a triangle's cross that is nearest to d.
Vec3 nearest_of_cross(const Vec3& cross, const Vec3& normal, const Vec3& d) {
    const Vec3 other = normal.cross(cross);
    const double a = cross.dot(d), b = other.dot(d);
    if (std::abs(a) >= std::abs(b)) return a < 0.0 ? Vec3(-cross) : cross;
    return b < 0.0 ? Vec3(-other) : other;
}

class Tracer {
  public:
    Tracer(const LinedMesh& lined, const TraceOptions& options, Poll& poll, const StepSeen& seen)
        : lined_(lined), mesh_(lined.mesh()), options_(options), poll_(poll), seen_(seen) {}

    TracedLine run(const LineStart& start) {
        const PolarPlace place = lined_.place_of(start.vertex, start.direction);
        if (place.triangle < 0) return std::move(line_);
        from_ = start.vertex;
        triangle_ = place.triangle;
        const int corner = mesh_.corner_of(triangle_, start.vertex);
        here_ = mesh_.point(start.vertex);
        line_.direction = start.direction;
        // A line of the same direction may be there already.
        for (const int k : {corner, (corner + 2) % 3}) {
            const auto& c = mesh_.triangle(triangle_);
            const int w = c[at(k)] == start.vertex ? c[at((k + 1) % 3)] : c[at(k)];
            const Vec3 side = (mesh_.point(w) - here_).normalized();
            if (lined_.is_wall(triangle_, k) && side.cross(line_.direction).norm() < least_inward &&
                side.dot(line_.direction) > 0.0)
                return std::move(line_);
        }
        ++visits_[triangle_];
        if (meets(triangle_)) return std::move(line_);
        leave_by((corner + 1) % 3, -1);
        while (step()) poll_();
        return std::move(line_);
    }

  private:
    /// Whether a vertex that is looked for is at the triangle; ends there.
    bool meets(int t) {
        if (options_.meets == nullptr) return false;
        const auto& corners = mesh_.triangle(t);
        if (std::find(corners.begin(), corners.end(), from_) == corners.end()) from_ = -1;
        for (const int v : corners) {
            if (v == from_ || v >= int(options_.meets->size()) || (*options_.meets)[at(v)] == 0)
                continue;
            line_.end = LineEnd::Vertex;
            line_.end_vertex = v;
            return true;
        }
        return false;
    }

    /// Goes straight on to side `one` of the triangle, or to `other` where that is met first.
    void leave_by(int one, int other) {
        const auto& c = mesh_.triangle(triangle_);
        const Vec3 normal = mesh_.area_vector(triangle_).normalized();
        side_ = one;
        if (other >= 0) {
            // The vertex between both sides decides.
            const Vec3 apex = mesh_.point(c[at(other)]) - here_;
            if (line_.direction.cross(apex).dot(normal) <= 0.0) side_ = other;
        }
        const int a = c[at(side_)], b = c[at((side_ + 1) % 3)];
        const Vec3 across = normal.cross(line_.direction);
        const double da = across.dot(mesh_.point(a) - here_),
                     db = across.dot(mesh_.point(b) - here_);
        const double t = da == db ? 0.5 : std::clamp(da / (da - db), 0.0, 1.0);
        const SidePoint next{a, b, t};
        const Vec3 there = lined_.point(next);
        if (seen_) seen_(triangle_, here_, there, line_.length);
        line_.length += (there - here_).norm();
        line_.points.push_back(next);
        here_ = there;
    }

    [[nodiscard]] bool crosses_well(const Vec3& edge) const {
        return edge.cross(line_.direction).norm() > least_crossing;
    }

    /// Into the next triangle and through it; false when the line ends.
    bool step() {
        const auto& c = mesh_.triangle(triangle_);
        const int a = c[at(side_)], b = c[at((side_ + 1) % 3)];
        const Vec3 edge = (mesh_.point(b) - mesh_.point(a)).normalized();
        if (lined_.is_feature(triangle_, side_) ||
            (lined_.is_line(a, b) && !(options_.crosses_lines && crosses_well(edge)))) {
            line_.end = LineEnd::Wall;
            return false;
        }
        const int next = across(mesh_, triangle_, side_);
        const Vec3 before = mesh_.area_vector(triangle_).normalized(),
                   after = mesh_.area_vector(next).normalized();
        if (!before.allFinite() || !after.allFinite()) return false;
        // Sides lie to the left of their triangles' inside: what crosses one goes to its right.
        const Vec3 out = edge.cross(before), in = edge.cross(after);
        const auto unfolded = [&](const Vec3& d) {
            return Vec3(edge.dot(d) * edge + out.dot(d) * in);
        };
        const Vec3 straight = unfolded(line_.direction);
        Vec3 way = unfolded(nearest_of_cross(lined_.direction(triangle_), before, line_.direction));
        way = (way + nearest_of_cross(lined_.direction(next), after, straight)).normalized();
        if (options_.straight) way = straight;
        if (options_.deviation != 0.0)
            way = std::cos(options_.deviation) * way +
                  std::sin(options_.deviation) * after.cross(way);
        if (!(way.dot(in) > least_inward)) way = straight;
        if (!(way.dot(in) > least_inward))
            way = ((way - way.dot(in) * in).normalized() + 2.0 * least_inward * in).normalized();
        if (!way.allFinite()) return false;
        line_.direction = way;
        if (++visits_[next] > options_.passes) {
            line_.end = LineEnd::Own;
            return false;
        }
        triangle_ = next;
        if (meets(next)) return false;
        int k = 0;
        while (mesh_.triangle(next)[at(k)] != b) ++k;
        // The side that was crossed is k, from b to a; the one from a to the apex comes next.
        leave_by((k + 1) % 3, (k + 2) % 3);
        return true;
    }

    const LinedMesh& lined_;
    const geom::EditableMesh& mesh_;
    const TraceOptions& options_;
    Poll& poll_;
    const StepSeen& seen_;
    TracedLine line_;
    int from_ = -1, triangle_ = -1, side_ = -1;
    Vec3 here_ = Vec3::Zero();
    std::map<int, int> visits_;  ///< of triangles
};

}  // namespace

TracedLine trace_line(const LinedMesh& lined, const LineStart& start, const TraceOptions& options,
                      Poll& poll, const StepSeen& seen) {
    return Tracer(lined, options, poll, seen).run(start);
}

}  // namespace patchwright::cage
