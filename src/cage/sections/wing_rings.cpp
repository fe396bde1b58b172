#include "cage/sections/wing.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Where the points of a section are from the nose to the trailing edge, as shares of a side's
// length: denser towards the nose, as the curvature of usual sections is.
constexpr std::array<double, 7> usual_shares{1.0, 0.825, 0.565, 0.385, 0.21, 0.105, 0.035};
// How far from the nose the points next to it lie, in nose radii: where a section has turned by
// about 50 degrees. As shares of a side's length, which bound it: sharper noses would get quads too
// narrow, blunter ones leave the next point of usual_shares.
constexpr double beside_nose_radii = 0.9, nearest_to_nose = 0.003, farthest_from_nose = 0.02;
// Of the span: points farther from a feature than this are not put onto it.
constexpr double onto_feature_rel = 0.01;
// Half of the share of a side between two points that tell its direction.
constexpr double direction_share = 0.01;
// A ring that a rounded tip gets beyond the last section: how far it goes from there to the end of
// the body, and how wide it is in widths of that section.
constexpr double tip_rise = 0.8, tip_width = 0.6;
// At the trailing edge and the nose the way to the end starts this far from them, as a share of the
// way to the next column.
constexpr double inward_share = 0.2;
// Halvings that find where the body ends: 24 leave 1e-7 of the way.
constexpr int halvings = 24;
// Sine of the slope from which on a wing is a fin: y then tells its upper side, not z.
constexpr double upright = 0.3;

class WingRings {
  public:
    WingRings(const Wing& wing, const geom::ModelSurface& reference, const WingOptions& options,
              Poll& poll)
        : wing_(wing), reference_(reference), columns_(options.columns), poll_(poll) {}

    Blocks run() {
        share_columns();
        for (std::size_t i = 0; i < wing_.sections.size(); ++i) add_ring(wing_.sections[i]);
        for (const WingEnd& end : wing_.ends) finish_end(end);
        connect();
        return std::move(blocks_);
    }

    [[nodiscard]] int ring_size() const {
        return 2 * columns_ - (wing_.blunt ? 0 : 1) + (wing_.nose_line ? 1 : 0);
    }

  private:
    /// The same shares of the sides' lengths in all rings: dense at the nose; where no line runs
    /// on it, its points lie where the section has turned by about 50 degrees.
    void share_columns() {
        std::vector<double> radii;
        for (const WingSection& s : wing_.sections)
            radii.push_back(s.nose_radius / (0.5 * (s.length(0) + s.length(1))));
        std::nth_element(radii.begin(), radii.begin() + std::ptrdiff_t(radii.size() / 2),
                         radii.end());
        const double nose = std::clamp(beside_nose_radii * radii[radii.size() / 2], nearest_to_nose,
                                       farthest_from_nose);
        const auto& usual = usual_shares;
        const int inner = columns_ - 1;
        for (int j = 0; j < inner; ++j) {
            const double x = double(j) / (inner - 1) * (usual.size() - 1);
            const auto i = std::min(std::size_t(x), usual.size() - 2);
            shares_.push_back(1.0 - (usual[i] + (x - double(i)) * (usual[i + 1] - usual[i])));
        }
        shares_.push_back(1.0 - nose);
    }

    [[nodiscard]] bool on_nose(int j) const { return wing_.nose_line && j == columns_; }
    /// Side and number of the column of a ring's point.
    [[nodiscard]] std::pair<int, int> column(int j) const {
        const int second = 2 * columns_ - (wing_.nose_line ? 0 : 1);
        return j < columns_ ? std::pair(0, j) : std::pair(1, second - j);
    }
    /// The point across, on the other side; itself at a sharp trailing edge and on the nose's line.
    [[nodiscard]] int across(int j) const {
        return wing_.blunt ? ring_size() - 1 - j : (ring_size() - j) % ring_size();
    }
    [[nodiscard]] bool is_tail(int j) const { return j == 0 || (wing_.blunt && across(j) == 0); }

    [[nodiscard]] Vec3 on_feature(const Vec3& p, geom::FeatureKind kind) const {
        const auto feature = reference_.feature_point(p, kind);
        return feature && feature->distance < onto_feature_rel * wing_.span ? feature->point : p;
    }

    [[nodiscard]] Vec3 on_nose_line(const Vec3& p) const {
        geom::FeaturePoint best;
        best.point = p;
        best.distance = onto_feature_rel * wing_.span;
        for (const int curve : wing_.lines.nose) {
            const auto on_curve = reference_.nearest_on_curve(curve, p);
            if (on_curve.distance < best.distance) best = on_curve;
        }
        return best.point;
    }

    void add_ring(const WingSection& section) {
        for (int j = 0; j < ring_size(); ++j) {
            poll_();
            if (on_nose(j)) {
                const Vec3 p = section.nose();
                blocks_.points.push_back(section.nose_on_line ? on_nose_line(p) : p);
                continue;
            }
            const auto [side, k] = column(j);
            const double share = shares_[std::size_t(k)];
            const Vec3 p = section.at(side, share);
            if (k == 0) {
                blocks_.points.push_back(section.faded ? p
                                                       : on_feature(p, geom::FeatureKind::Sharp));
                continue;
            }
            const Vec3 along = (section.at(side, share + direction_share) -
                                section.at(side, share - direction_share)) *
                               (side == 0 ? 1.0 : -1.0);
            const Vec3 outward = along.cross(wing_.slicer.normal()).normalized();
            blocks_.points.push_back(reference_.foot_point(p, outward).point);
        }
    }

    [[nodiscard]] int ring_count() const { return int(blocks_.points.size()) / ring_size(); }

    [[nodiscard]] const WingSection& section_at(const WingEnd& end) const {
        return end.outward < 0.0 ? wing_.sections.front() : wing_.sections.back();
    }

    void finish_end(const WingEnd& end) {
        const int ring = end.outward < 0.0 ? 0 : ring_count() - 1;
        if (end.kind == EndKind::Rounded) {
            add_tip_ring(end, ring);
            return;
        }
        if (end.kind == EndKind::Ridge) {
            const int tail = ring * ring_size(), nose = tail + columns_;
            const Vec3 front = blocks_.points[std::size_t(nose)];
            blocks_.points[std::size_t(tail)] = ridge_point(end, front, 0.0);
            if (section_at(end).nose_on_line)
                blocks_.points[std::size_t(nose)] = ridge_point(end, front, 1.0);
            return;
        }
        const auto kind =
            end.kind == EndKind::Lid ? geom::FeatureKind::Sharp : geom::FeatureKind::Free;
        for (int j = 0; j < ring_size(); ++j) {
            Vec3& p = blocks_.points[std::size_t(ring * ring_size() + j)];
            p = on_feature(p, kind);
        }
    }

    [[nodiscard]] bool inside(const Vec3& p) const {
        const geom::FootPoint foot = reference_.foot_point(p);
        return (p - foot.point).dot(foot.normal) < 0.0;
    }

    /// How far the body goes on from a point inside, along the span.
    [[nodiscard]] double way_out(const Vec3& p, const Vec3& direction, double longest) const {
        double in = 0.0, out = longest;
        for (int i = 0; i < halvings; ++i) {
            const double middle = 0.5 * (in + out);
            (inside(p + middle * direction) ? in : out) = middle;
        }
        return in;
    }

    /// Of a ridge, from the end of the trailing edge to the nose of the last ring.
    [[nodiscard]] Vec3 ridge_point(const WingEnd& end, const Vec3& nose, double share) const {
        const double length = reference_.features().curves[std::size_t(end.ridge)].length;
        const double front = reference_.nearest_on_curve(end.ridge, nose).arc_length,
                     tail = end.starts_at_tail ? 0.0 : length;
        return reference_.point_on_curve(end.ridge, tail + share * (front - tail)).point;
    }

    /// A ring beyond a section: where the tip has turned half of its way to the end.
    void add_tip_ring(const WingEnd& end, int ring) {
        const Vec3 direction = end.outward * wing_.slicer.normal();
        std::vector<Vec3> tip;
        for (int j = 0; j < ring_size(); ++j) tip.push_back(towards_tip(end, ring, j, direction));
        const auto where = end.outward < 0.0 ? blocks_.points.begin() : blocks_.points.end();
        blocks_.points.insert(where, tip.begin(), tip.end());
    }

    [[nodiscard]] Vec3 ring_point(int ring, int j) const {
        return blocks_.points[std::size_t(ring * ring_size() + j)];
    }

    [[nodiscard]] Vec3 towards_tip(const WingEnd& end, int ring, int j,
                                   const Vec3& direction) const {
        poll_();
        const Vec3 own = ring_point(ring, j), middle = 0.5 * (own + ring_point(ring, across(j)));
        // At the trailing edge the middle is on the surface, as on the nose: a little away from
        // there it is not.
        const int next = on_nose(j) || j > 1 ? j - 1 : 1;
        const bool at_border = is_tail(j) || on_nose(j);
        const Vec3 within = at_border ? Vec3((1.0 - inward_share) * middle +
                                             0.5 * inward_share * ring_point(ring, next) +
                                             0.5 * inward_share * ring_point(ring, across(next)))
                                      : middle;
        constexpr double past_the_end = 1.2;
        const double longest = past_the_end * std::abs(end.extreme - end.ring);
        const Vec3 rise = tip_rise * way_out(within, direction, longest) * direction;
        const Vec3 p = middle + rise + tip_width * (own - middle);
        if (is_tail(j)) {
            const auto feature = reference_.feature_point(p, geom::FeatureKind::Sharp);
            return feature ? feature->point : p;
        }
        const Vec3 side = own - middle;
        const Vec3 outward =
            side.norm() > 0.0 ? Vec3((direction + side.normalized()).normalized()) : direction;
        return reference_.foot_point(p, outward).point;
    }

    void add_face(std::vector<int> corners, std::string group) {
        blocks_.faces.push_back(std::move(corners));
        blocks_.groups.push_back(std::move(group));
    }

    void connect() {
        const int n = ring_size(), rings = ring_count();
        const auto id = [&](int ring, int j) { return ring * n + (j + n) % n; };
        const WingSection& middle = wing_.sections[wing_.sections.size() / 2];
        const Vec3 up = middle.at(1, 0.5) - middle.at(0, 0.5);
        const bool upper_last =
            std::abs(up.z()) > upright * up.norm() ? up.z() > 0.0 : up.y() > 0.0;
        const int first_section = wing_.ends[0].kind == EndKind::Rounded ? 1 : 0;
        for (int i = 0; i + 1 < rings; ++i) {
            for (int j = 0; j < n; ++j) {
                const bool strip = wing_.blunt && j == n - 1;
                const bool nose = j == columns_ - 1 || on_nose(j);
                const bool last = j >= columns_;
                add_face({id(i, j), id(i, j + 1), id(i + 1, j + 1), id(i + 1, j)},
                         strip                ? "te"
                         : nose               ? "nose"
                         : last == upper_last ? "upper"
                                              : "lower");
            }
            const auto faded = [&](int ring) {
                const int s = std::clamp(ring - first_section, 0, int(wing_.sections.size()) - 1);
                return wing_.sections[std::size_t(s)].faded;
            };
            if (!faded(i) && !faded(i + 1)) {
                blocks_.creases.emplace_back(id(i, 0), id(i + 1, 0));
                if (wing_.blunt) blocks_.creases.emplace_back(id(i, n - 1), id(i + 1, n - 1));
            }
            const int interval = i - first_section;
            if (interval >= 0 && interval < int(wing_.nose_on_line.size()) &&
                wing_.nose_on_line[std::size_t(interval)] != 0)
                blocks_.creases.emplace_back(id(i, columns_), id(i + 1, columns_));
        }
        hold_ends_of_creases(1, rings - 1);
        for (const WingEnd& end : wing_.ends) {
            if (end.kind == EndKind::Open) continue;
            const int ring = end.outward < 0.0 ? 0 : rings - 1;
            end.kind == EndKind::Ridge ? close_at_ridge(end, ring) : close(end, ring);
        }
    }

    /// Lines that begin or end within the skin do so in corners, and pass through the model's: a
    /// fit keeps those in their places.
    void hold_ends_of_creases(int first_ring, int last_ring) {
        constexpr double same_rel = 1e-4;
        const auto is_corner = [&](int v) {
            const auto corner =
                reference_.feature_point(blocks_.points[std::size_t(v)], geom::FeatureKind::Corner);
            return corner && corner->distance < same_rel * wing_.span;
        };
        std::vector<int> edges(blocks_.points.size(), 0);
        for (const auto& [a, b] : blocks_.creases) {
            ++edges[std::size_t(a)];
            ++edges[std::size_t(b)];
        }
        for (int v = first_ring * ring_size(); v < last_ring * ring_size(); ++v)
            if (edges[std::size_t(v)] == 1 || (edges[std::size_t(v)] == 2 && is_corner(v)))
                blocks_.corners.push_back(v);
    }

    void add_end_face(const WingEnd& end, std::vector<int> corners) {
        const bool first = end.outward < 0.0;
        if (first) std::reverse(corners.begin(), corners.end());
        add_face(std::move(corners), first ? "root" : "tip");
    }

    /// Quads between both sides of a ring.
    void close(const WingEnd& end, int ring) {
        const int n = ring_size(), last = columns_ - 1 + (wing_.nose_line ? 1 : 0);
        const auto id = [&](int j) { return ring * n + (j + n) % n; };
        for (int j = 0; j < last; ++j) {
            std::vector<int> corners{id(j), id(j + 1)};
            if (across(j + 1) != j + 1) corners.push_back(id(across(j + 1)));
            if (across(j) != j) corners.push_back(id(across(j)));
            add_end_face(end, std::move(corners));
        }
        if (end.kind == EndKind::Lid) {
            for (int j = 0; j < n; ++j) blocks_.creases.emplace_back(id(j), id(j + 1));
        } else if (wing_.blunt) {
            blocks_.creases.emplace_back(id(n - 1), id(0));
        }
    }

    /// Quads from both sides of a ring to points on the ridge, which runs from the ring's trailing
    /// edge to its nose; the columns next to both have no point on it, and end with valence 3.
    void close_at_ridge(const WingEnd& end, int ring) {
        const int tail = ring * ring_size(), nose = tail + columns_, last = columns_ - 2;
        const auto id = [&](int j) { return tail + j; };
        const auto at = [&](int k) {
            return k < 2 ? tail : k > last ? nose : int(blocks_.points.size()) - 1 - last + k;
        };
        const Vec3 front = blocks_.points[std::size_t(nose)];
        for (int k = 2; k <= last; ++k)
            blocks_.points.push_back(ridge_point(end, front, shares_[std::size_t(k)]));
        for (int k = 1; k <= last; ++k) {
            if (k < last || section_at(end).nose_on_line)
                blocks_.creases.emplace_back(at(k), at(k + 1));
            add_end_face(end, {at(k), id(k), id(k + 1), at(k + 1)});
            add_end_face(end, {at(k + 1), id(across(k + 1)), id(across(k)), at(k)});
        }
        blocks_.corners.push_back(tail);
    }

    const Wing& wing_;
    const geom::ModelSurface& reference_;
    int columns_;
    Poll& poll_;
    std::vector<double> shares_;
    Blocks blocks_;
};

const char* name_of(EndKind kind) {
    switch (kind) {
        case EndKind::Lid: return "planar";
        case EndKind::Open: return "open";
        case EndKind::Rounded: return "rounded";
        case EndKind::Ridge: return "sharp";
    }
    return "";
}

}  // namespace

Blocks wing_blocks(const Wing& wing, const geom::ModelSurface& reference,
                   const WingOptions& options, Poll& poll) {
    return WingRings(wing, reference, options, poll).run();
}

std::string describe(const Wing& wing, const WingOptions& options) {
    const bool fades = std::any_of(wing.sections.begin(), wing.sections.end(),
                                   [](const WingSection& s) { return s.faded; });
    int rings = int(wing.sections.size());
    for (const WingEnd& end : wing.ends) rings += end.kind == EndKind::Rounded ? 1 : 0;
    return fmt::format("{}: {} points around x {} rings, {} trailing edge{}{}, ends {} and {}",
                       wing.blade ? "blade" : "wing",
                       2 * options.columns - (wing.blunt ? 0 : 1) + (wing.nose_line ? 1 : 0), rings,
                       wing.blunt ? "blunt" : "sharp", fades ? " that fades" : "",
                       wing.nose_line ? ", line along the nose" : "", name_of(wing.ends[0].kind),
                       name_of(wing.ends[1].kind));
}

}  // namespace patchwright::cage
