#include "cage/blocks/corner_rings.h"

#include "geom/angle.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Three quads that have 72 degrees each do as they are.
constexpr double widest_left_rad = 1.2 * std::numbers::pi;
// Those that subd::CornerSectors turns: of two quads no angles help (decision 056).
constexpr std::size_t fewest_quads = 3, most_quads = 4;
// How many quads around those of a corner are shaped anew.
constexpr int shaped_around = 3;

/// The quads at a point between two features, one after the other.
struct Sector {
    int corner;
    std::vector<int> edges;      ///< their ends: one more than quads, first and last on features
    std::vector<int> diagonals;  ///< opposite corners of the quads
    Vec3 normal = Vec3::Zero();  ///< of the model, the sum of those of the quads
};

class CornerRings {
  public:
    CornerRings(const QuadsOnModel& quads, std::vector<Vec3>& points,
                const geom::ModelSurface& reference)
        : quads_(quads), points_(points), reference_(reference), freedom_(quads.freedom) {
        for (const auto& [a, b] : quads.creases) creases_.insert(std::minmax(a, b));
        for (std::size_t f = 0; f < quads.faces.size(); ++f)
            for (int k = 0; k < 4; ++k) side_of_[{vertex(f, k), vertex(f, k + 1)}] = {f, k};
    }

    void run(Poll& poll) {
        for (const auto& [side, place] : side_of_) {
            if (!is_feature(side.first, side.second)) continue;
            const std::optional<Sector> sector = sector_from(place.first, place.second);
            if (!sector) continue;
            const double angle = angle_of(*sector);
            if (angle > widest_left_rad) set_even(*sector, angle);
        }
        if (placed_.empty()) return;
        hold_far_points();
        shape_quads({quads_.faces, freedom_, quads_.creases, quads_.normals}, points_, reference_,
                    poll);
    }

  private:
    [[nodiscard]] int vertex(std::size_t face, int k) const {
        return quads_.faces[face][at(k % 4)];
    }

    [[nodiscard]] bool is_feature(int a, int b) const {
        return creases_.contains(std::minmax(a, b)) || !side_of_.contains({b, a}) ||
               !side_of_.contains({a, b});
    }

    /// Of the corner k of a face, whose side k is on a feature; nothing where it ends at the same
    /// edge, as around the end of a crease, or has other numbers of quads.
    [[nodiscard]] std::optional<Sector> sector_from(std::size_t face, int k) const {
        Sector sector{.corner = vertex(face, k), .edges = {vertex(face, k + 1)}, .diagonals = {}};
        while (sector.diagonals.size() <= most_quads) {
            sector.diagonals.push_back(vertex(face, k + 2));
            sector.edges.push_back(vertex(face, k + 3));
            sector.normal += quads_.normals[face];
            if (is_feature(sector.corner, sector.edges.back())) break;
            std::tie(face, k) = side_of_.at({sector.corner, sector.edges.back()});
        }
        if (sector.diagonals.size() < fewest_quads || sector.diagonals.size() > most_quads ||
            sector.edges.front() == sector.edges.back())
            return std::nullopt;
        sector.normal.normalize();
        return sector;
    }

    /// Along the model, at right angles to a sector's normal.
    [[nodiscard]] Vec3 way(const Sector& sector, int to) const {
        const Vec3 all = points_[at(to)] - points_[at(sector.corner)];
        return all - all.dot(sector.normal) * sector.normal;
    }

    /// From the first edge to the last one, which may be a whole turn and more; by the angles of
    /// the quads, which are not exact where these fold.
    [[nodiscard]] double angle_of(const Sector& sector) const {
        double sum = 0.0;
        for (std::size_t i = 0; i + 1 < sector.edges.size(); ++i)
            sum +=
                geom::angle_between(way(sector, sector.edges[i]), way(sector, sector.edges[i + 1]));
        const Vec3 first = way(sector, sector.edges.front()),
                   last = way(sector, sector.edges.back());
        const double within_turn =
            std::atan2(sector.normal.dot(first.cross(last)), first.dot(last));
        constexpr double turn = 2.0 * std::numbers::pi;
        return within_turn + turn * std::max(0.0, std::round((sum - within_turn) / turn));
    }

    void set_even(const Sector& sector, double angle) {
        const Vec3 corner = points_[at(sector.corner)];
        const Vec3 first = way(sector, sector.edges.front()),
                   last = way(sector, sector.edges.back());
        const std::size_t quads = sector.diagonals.size();
        std::vector<Vec3> ends{points_[at(sector.edges.front())]};
        for (std::size_t i = 1; i < quads; ++i) {
            const double share = double(i) / double(quads);
            const double of_features =
                std::pow(first.norm(), 1.0 - share) * std::pow(last.norm(), share);
            const Eigen::AngleAxisd turned(share * angle, sector.normal);
            ends.emplace_back(corner + std::min(of_features, way(sector, sector.edges[i]).norm()) *
                                           (turned * first.normalized()));
        }
        ends.push_back(points_[at(sector.edges.back())]);
        for (std::size_t i = 1; i < quads; ++i) {
            const int end = sector.edges[i];
            if (!freedom_[at(end)].free) continue;
            put(end, ends[i], sector.normal);
            freedom_[at(end)] = {.free = false, .line = (ends[i] - corner).normalized()};
        }
        for (std::size_t i = 0; i < quads; ++i) {
            const int opposite = sector.diagonals[i];
            if (freedom_[at(opposite)].free && !placed_.contains(opposite))
                put(opposite, ends[i] + ends[i + 1] - corner, sector.normal);
        }
    }

    void put(int v, const Vec3& there, const Vec3& normal) {
        points_[at(v)] = reference_.foot_point(there, normal).point;
        placed_.insert(v);
    }

    void hold_far_points() {
        std::set<int> near = placed_;
        for (int step = 0; step < shaped_around; ++step) {
            const std::set<int> nearer = near;
            for (const std::vector<int>& face : quads_.faces)
                if (std::ranges::any_of(face, [&](int v) { return nearer.contains(v); }))
                    near.insert(face.begin(), face.end());
        }
        for (std::size_t v = 0; v < freedom_.size(); ++v)
            if (!near.contains(int(v))) freedom_[v] = {.free = false};
    }

    const QuadsOnModel& quads_;
    std::vector<Vec3>& points_;
    const geom::ModelSurface& reference_;
    std::vector<Freedom> freedom_;
    std::set<int> placed_;
    std::set<std::pair<int, int>> creases_;
    /// By its ends, counter-clockwise: face and number of the side.
    std::map<std::pair<int, int>, std::pair<std::size_t, int>> side_of_;
};

}  // namespace

void even_corner_rings(const QuadsOnModel& quads, std::vector<Vec3>& points,
                       const geom::ModelSurface& reference, Poll& poll) {
    CornerRings(quads, points, reference).run(poll);
}

}  // namespace patchwright::cage
