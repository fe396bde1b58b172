#include "fit/solve/symmetry.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace patchwright::fit {

namespace {

using geom::Vec3;
using mesh::CornerId;
using mesh::EdgeId;
using mesh::VertexId;

constexpr int curve_samples = 24;  // of each piece that is compared with the plane
// The sine of half a degree: what still counts as a right angle.
constexpr double right_angle = 0.0087;
// Points this near to the plane lie on it: a share of the diagonal for imprecise CAD, of the
// tolerance so that moving them onto the plane is not noticed, and of the model's width across the
// plane, as both sides of a thin plate are not one plane.
constexpr double on_plane_rel = 1e-5, on_plane_of_tolerance = 0.1, on_plane_of_width = 1e-3;
// Normals are taken this share of the diagonal inside of the plane, where foot points are unique.
constexpr double inward_rel = 1e-4;
/// Such a point's foot is off by no more than this share of its way when the surface goes on.
constexpr double foot_share = 0.1;

class PlaneSearch {
  public:
    PlaneSearch(const geom::ReferenceSurface& reference, const FitOptions& options)
        : reference_(reference),
          diagonal_(reference.bounds().diagonal()),
          off_((on_plane_of_width * (reference.bounds().max - reference.bounds().min))
                   .cwiseMin(std::min(on_plane_rel * diagonal_,
                                      on_plane_of_tolerance * options.tolerance_mm))) {}

    [[nodiscard]] bool ends_at(int axis) const {
        const geom::Box3 box = reference_.bounds();
        return is_near(box.min[axis], axis) || is_near(box.max[axis], axis);
    }

    [[nodiscard]] bool lies_in(const FeaturePath& path, int axis) const {
        if (path.empty()) return false;
        bool inside = true;
        visit(path, [&](const Vec3& p) { inside = inside && is_near(p[axis], axis); });
        return inside;
    }

    [[nodiscard]] bool is_at_right_angles(const FeaturePath& path, int axis) const {
        const geom::Box3 box = reference_.bounds();
        const double inward = std::copysign(inward_rel * diagonal_, box.centre()[axis]);
        bool right = true;
        visit(path, [&](const Vec3& p) {
            const auto foot = reference_.foot_point(p + inward * Vec3::Unit(axis));
            right = right && foot.distance < foot_share * std::abs(inward) &&
                    std::abs(foot.normal[axis]) <= right_angle;
        });
        return right;
    }

    [[nodiscard]] bool is_near(double coordinate, int axis) const {
        return std::abs(coordinate) <= off_[axis];
    }

  private:
    template <class Visit>
    void visit(const FeaturePath& path, const Visit& visit_point) const {
        for (const FeaturePiece& piece : path) {
            for (int k = 0; k <= curve_samples; ++k) {
                const double s = piece.range.from +
                                 double(k) / curve_samples * (piece.range.to - piece.range.from);
                visit_point(reference_.point_on_curve(piece.curve, s).point);
            }
        }
    }

    const geom::ReferenceSurface& reference_;
    double diagonal_;
    Vec3 off_;  ///< by axis
};

/// The other ends of the edges at a vertex.
std::vector<VertexId> neighbours(const mesh::Topology& topology, VertexId v) {
    std::vector<VertexId> result;
    const CornerId first = topology.corner(v);
    for (CornerId c = first;;) {
        result.push_back(topology.vertex(topology.next(c)));
        const CornerId arriving = topology.previous(c);
        c = topology.twin(arriving);
        if (!c.valid()) {
            result.push_back(topology.vertex(arriving));
            return result;
        }
        if (c == first) return result;
    }
}

/// The third vertex of the line that ends at `end` and goes on to `next`, if it has a runout there.
std::optional<VertexId> third_on_runout(const Topology& topology, VertexId end, VertexId next) {
    const CornerId first = topology.corner(end);
    CornerId c = first;
    do {
        if (topology.vertex(topology.next(c)) == next) {
            if (!topology.is_runout(topology.edge(c), end)) return std::nullopt;
            const CornerId on = topology.next(topology.twin(topology.next(c)));
            return topology.vertex(topology.next(on));
        }
        c = topology.rotate(c);
    } while (c.valid() && c != first);
    return std::nullopt;
}

/// Where vertex `v` has to be for right angles. With points q, p, r of a line from the plane on,
/// the limit surface's derivative there goes by p - q, with a runout by 11 p - 9 q - 2 r.
PointConstraints::Follower follower(const Topology& topology, const std::map<int, int>& leaders,
                                    int v, int leader) {
    PointConstraints::Follower result{v, leader, leader};
    const auto third = third_on_runout(topology, VertexId{leader}, VertexId{v});
    if (!third) return result;
    const auto opposite = leaders.find(third->value);
    if (opposite == leaders.end() || opposite->second < 0) {
        result.other = third->value;
        result.share = 2.0 / 11.0;
        return result;
    }
    // The line has three edges, and r follows as well: the same at its end, solved for p.
    result.other = opposite->second;
    result.share =
        third_on_runout(topology, VertexId{result.other}, *third) ? 2.0 / 13.0 : 2.0 / 11.0;
    return result;
}

std::optional<SymmetryPlane> on_plane(int axis, const mesh::Topology& topology,
                                      const geom::Points& points, const CurveSampling& curves,
                                      const FeatureMatch& match, const PlaneSearch& search) {
    SymmetryPlane plane{.axis = axis};
    std::vector<char> on(std::size_t(topology.vertex_count()), 0);
    // What all chains through a vertex agree on.
    std::map<VertexId, bool> right;
    for (std::size_t k = 0; k < curves.chains.size(); ++k) {
        if (!search.lies_in(match.paths[k], axis)) continue;
        const bool is_right = search.is_at_right_angles(match.paths[k], axis);
        for (const VertexId v : curves.chains[k].vertices) {
            on[v.index()] = 1;
            const auto [entry, added] = right.try_emplace(v, is_right);
            entry->second = entry->second && is_right;
        }
    }
    if (right.empty()) return std::nullopt;
    for (const VertexId v : topology.vertices()) {
        if (search.is_near(points(v.value, axis), axis)) on[v.index()] = 1;
        if (on[v.index()] != 0) plane.vertices.push_back(v.value);
    }
    std::map<int, int> leaders;  // of a follower; -1 where there are several
    for (const auto& [v, is_right] : right) {
        if (!is_right) continue;
        std::vector<VertexId> beyond;
        for (const VertexId n : neighbours(topology, v)) {
            if (on[n.index()] == 0) beyond.push_back(n);
        }
        if (beyond.size() != 1 || topology.is_pinned(beyond[0])) continue;
        const auto [entry, added] = leaders.try_emplace(beyond[0].value, v.value);
        if (!added) entry->second = -1;
    }
    for (const auto& [v, leader] : leaders) {
        if (leader >= 0) plane.followers.push_back(follower(topology, leaders, v, leader));
    }
    return plane;
}

}  // namespace

std::optional<SymmetryPlane> find_symmetry(const mesh::Topology& topology,
                                           const geom::Points& points, const CurveSampling& curves,
                                           const FeatureMatch& match,
                                           const geom::ReferenceSurface& reference,
                                           const FitOptions& options) {
    if (options.symmetry == Symmetry::None) return std::nullopt;
    const PlaneSearch search(reference, options);
    const auto plane = [&](int axis) {
        return on_plane(axis, topology, points, curves, match, search);
    };
    if (options.symmetry != Symmetry::Detect) {
        const int axis = static_cast<int>(options.symmetry) - static_cast<int>(Symmetry::X);
        auto asked = plane(axis);
        if (!asked) {
            throw base::UsageError(fmt::format(
                "symmetry: no sharp edges or borders of the cage belong to edges of the model that "
                "lie on the plane {} = 0",
                "xyz"[axis]));
        }
        return asked;
    }
    std::optional<SymmetryPlane> best;
    for (int axis = 0; axis < 3; ++axis) {
        if (!search.ends_at(axis)) continue;
        auto found = plane(axis);
        if (found && (!best || found->vertices.size() > best->vertices.size()))
            best = std::move(found);
    }
    return best;
}

}  // namespace patchwright::fit
