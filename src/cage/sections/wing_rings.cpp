#include "cage/sections/bend.h"
#include "cage/sections/wing.h"
#include "cage/sections/wing_columns.h"
#include "geom/angle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace patchwright::cage {

using geom::Vec3;

namespace {

// Of the span: points farther from a feature than this are not put onto it.
constexpr double onto_feature_rel = 0.01;
// Of the span: rings nearer to a sharp or bent curve around the body run along it.
constexpr double around_rel = 5e-3;
// At corners of the trailing edge: what smooth skin bears, 20 degrees.
constexpr double widest_past_half_turn_rad = 0.35;
// Half of the share of a side between two points that tell its direction.
constexpr double direction_share = 0.01;
// A ring that a rounded tip gets beyond the last section: how far it goes from there to the end of
// the body, and how wide it is in widths of that section.
constexpr double tip_rise = 0.8, tip_width = 0.6;
// The shortest face between the last section and a tip, in lengths of the longest one there; its
// section's points step back for it, by at most this share of the way to the section before.
constexpr double shortest_beside_tip = 0.5, longest_step_back = 0.5;
// At the trailing edge and the nose the way to the end starts this far from them, as a share of the
// way to the next column.
constexpr double inward_share = 0.2;
// Sine of the slope from which on a wing is a fin: y then tells its upper side, not z.
constexpr double upright = 0.3;

class WingRings {
  public:
    WingRings(const Wing& wing, const geom::ModelSurface& reference, const WingOptions& options,
              Poll& poll)
        : wing_(wing),
          reference_(reference),
          ring_{options.columns, wing.blunt, wing.nose_line},
          tolerance_mm_(options.tolerance_mm),
          poll_(poll),
          shares_(column_shares(wing.sections, options.columns)) {}

    Blocks run() {
        for (std::size_t i = 0; i < wing_.sections.size(); ++i) {
            add_ring(wing_.sections[i]);
            on_line_.push_back(lies_on_line(i));
        }
        for (const WingEnd& end : wing_.ends) finish_end(end);
        connect();
        return std::move(blocks_);
    }

  private:
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
        const Spine& spine = wing_.slicer.spine();
        const Vec3 span = spine.direction(spine.height(section.center));
        for (int j = 0; j < ring_.size(); ++j) {
            poll_();
            if (ring_.on_nose(j)) {
                const Vec3 p = section.nose();
                blocks_.points.push_back(section.nose_on_line ? on_nose_line(p) : p);
                continue;
            }
            const auto [side, k] = ring_.side_and_column(j);
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
            const Vec3 outward = along.cross(span).normalized();
            blocks_.points.push_back(reference_.foot_point(p, outward).point);
        }
    }

    /// Whether the last ring, of that section, is to be a crease: its points near the curves that
    /// run along it are then put onto them.
    bool lies_on_line(std::size_t section) {
        const auto& heights = wing_.heights;
        const double height = heights[section];
        const double below = section > 0 ? height - heights[section - 1] : 0.0,
                     above = section + 1 < heights.size() ? heights[section + 1] - height : 0.0;
        std::vector<int> along;
        bool needed = false;
        for (const int curve : wing_.lines.around) {
            const geom::FeatureCurve& line = reference_.features().curves[std::size_t(curve)];
            const double at = wing_.slicer.spine().height(line.start);
            if (std::abs(at - height) > around_rel * wing_.span) continue;
            along.push_back(curve);
            needed = needed || needs_crease(line, std::max(below, above), tolerance_mm_);
        }
        for (const int curve : along)
            if (needed) put_on(curve);
        return needed;
    }

    /// Points of the last ring near a curve, but not where that has ended.
    void put_on(int curve) {
        const geom::FeatureCurve& line = reference_.features().curves[std::size_t(curve)];
        for (int j = 0; j < ring_.size(); ++j) {
            poll_();
            Vec3& p = blocks_.points[blocks_.points.size() - std::size_t(ring_.size() - j)];
            const auto foot = reference_.nearest_on_curve(curve, p);
            const bool past_end =
                !line.closed && (foot.arc_length <= 0.0 || foot.arc_length >= line.length);
            if (!past_end && !ring_.is_tail(j) && foot.distance < onto_feature_rel * wing_.span)
                p = foot.point;
        }
    }

    [[nodiscard]] int ring_count() const { return int(blocks_.points.size()) / ring_.size(); }

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
            const int tail = ring * ring_.size(), nose = tail + ring_.of_side;
            const Vec3 front = blocks_.points[std::size_t(nose)];
            blocks_.points[std::size_t(tail)] = ridge_point(end, front, 0.0);
            if (section_at(end).nose_on_line)
                blocks_.points[std::size_t(nose)] = ridge_point(end, front, 1.0);
            return;
        }
        const auto kind =
            end.kind == EndKind::Lid ? geom::FeatureKind::Sharp : geom::FeatureKind::Free;
        for (int j = 0; j < ring_.size(); ++j) {
            Vec3& p = blocks_.points[std::size_t(ring * ring_.size() + j)];
            p = on_feature(p, kind);
        }
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
        const Vec3 direction = end.outward * wing_.slicer.spine().direction(end.extreme);
        std::vector<Vec3> tip;
        for (int j = 0; j < ring_.size(); ++j) tip.push_back(towards_tip(end, ring, j, direction));
        step_back_from_tip(end, ring, tip);
        const auto where = end.outward < 0.0 ? blocks_.points.begin() : blocks_.points.end();
        blocks_.points.insert(where, tip.begin(), tip.end());
    }

    /// Faces between a section and the tip become short where the tip's border nears the section,
    /// as at a nose in which the borders of a cap meet, or at a sharp trailing edge that ends
    /// there: the section's points step back from it. They step as far on both sides, so that lines
    /// run straight across thin trailing edges.
    void step_back_from_tip(const WingEnd& end, int ring, const std::vector<Vec3>& tip) {
        const std::size_t section = end.outward < 0.0 ? 0 : wing_.sections.size() - 1;
        if (on_line_[section] != 0) return;
        std::vector<double> lengths;
        for (int j = 0; j < ring_.size(); ++j)
            lengths.push_back((tip[std::size_t(j)] - ring_point(ring, j)).norm());
        const double least = shortest_beside_tip * *std::ranges::max_element(lengths);
        for (int j = 0; j < ring_.size(); ++j) {
            Vec3& own = blocks_.points[std::size_t(ring * ring_.size() + j)];
            const Vec3 inward = ring_point(end.outward < 0.0 ? ring + 1 : ring - 1, j) - own;
            const double length =
                std::midpoint(lengths[std::size_t(j)], lengths[std::size_t(ring_.across(j))]);
            const double step = std::min(least - length, longest_step_back * inward.norm());
            if (step <= 0.0) continue;
            const Vec3 p = own + step * inward.normalized();
            const bool on_line = ring_.on_nose(j) && section_at(end).nose_on_line;
            own = ring_.is_tail(j) ? on_feature(p, geom::FeatureKind::Sharp)
                  : on_line        ? on_nose_line(p)
                                   : reference_.foot_point(p).point;
        }
    }

    [[nodiscard]] Vec3 ring_point(int ring, int j) const {
        return blocks_.points[std::size_t(ring * ring_.size() + j)];
    }

    [[nodiscard]] Vec3 towards_tip(const WingEnd& end, int ring, int j,
                                   const Vec3& direction) const {
        poll_();
        const Vec3 own = ring_point(ring, j),
                   middle = 0.5 * (own + ring_point(ring, ring_.across(j)));
        // At the trailing edge the middle is on the surface, as on the nose: a little away from
        // there it is not.
        const int next = ring_.on_nose(j) || j > 1 ? j - 1 : 1;
        const bool at_border = ring_.is_tail(j) || ring_.on_nose(j);
        const Vec3 within =
            at_border
                ? Vec3((1.0 - inward_share) * middle + 0.5 * inward_share * ring_point(ring, next) +
                       0.5 * inward_share * ring_point(ring, ring_.across(next)))
                : middle;
        constexpr double past_the_end = 1.2;
        const double longest = past_the_end * std::abs(end.extreme - end.ring);
        const Vec3 rise = tip_rise * way_out(within, longest * direction, reference_) * direction;
        const Vec3 p = middle + rise + tip_width * (own - middle);
        if (ring_.is_tail(j)) {
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
        const int n = ring_.size(), rings = ring_count();
        const auto id = [&](int ring, int j) { return ring * n + (j + n) % n; };
        const WingSection& middle = wing_.sections[wing_.sections.size() / 2];
        const Vec3 up = middle.at(1, 0.5) - middle.at(0, 0.5);
        const bool upper_last =
            std::abs(up.z()) > upright * up.norm() ? up.z() > 0.0 : up.y() > 0.0;
        const int first_section = wing_.ends[0].kind == EndKind::Rounded ? 1 : 0;
        for (int i = 0; i + 1 < rings; ++i) {
            for (int j = 0; j < n; ++j) {
                const bool strip = wing_.blunt && j == n - 1;
                const bool nose = j == ring_.of_side - 1 || ring_.on_nose(j);
                const bool last = j >= ring_.of_side;
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
                blocks_.creases.emplace_back(id(i, ring_.of_side), id(i + 1, ring_.of_side));
        }
        for (int i = 1; i + 1 < rings; ++i) {
            const int section = i - first_section;
            const bool on_line = section >= 0 && section < int(on_line_.size()) &&
                                 on_line_[std::size_t(section)] != 0;
            // Where the curve is not sharp the model mostly has a slighter bend.
            if (on_line || tail_turns_back(i)) crease_ring(i);
        }
        hold_ends_of_creases();
        for (const WingEnd& end : wing_.ends) {
            if (end.kind == EndKind::Open) continue;
            const int ring = end.outward < 0.0 ? 0 : rings - 1;
            end.kind == EndKind::Ridge ? close_at_ridge(end, ring) : close(end, ring);
        }
    }

    /// Whether a corner of the model is at a point.
    [[nodiscard]] bool is_corner(int v) const {
        constexpr double same_rel = 1e-4;
        const auto corner =
            reference_.feature_point(blocks_.points[std::size_t(v)], geom::FeatureKind::Corner);
        return corner && corner->distance < same_rel * wing_.span;
    }

    /// Lines that begin or end within the skin do so in corners, and pass through the model's: a
    /// fit keeps those in their places. So it does where a line ends at a tip.
    void hold_ends_of_creases() {
        std::vector<int> edges(blocks_.points.size(), 0);
        for (const auto& [a, b] : blocks_.creases) {
            ++edges[std::size_t(a)];
            ++edges[std::size_t(b)];
        }
        const int n = ring_.size(), last = ring_count() - 1;
        for (int v = 0; v < n * ring_count(); ++v) {
            const int ring = v / n;
            const bool at_end = ring == 0 || ring == last;
            const EndKind kind = wing_.ends[ring == 0 ? 0 : 1].kind;
            if (at_end && kind != EndKind::Rounded) continue;
            const int count = edges[std::size_t(v)];
            if ((count == 1 && (!at_end || is_corner(v))) ||
                (count == 2 && !at_end && is_corner(v)))
                blocks_.corners.push_back(v);
        }
    }

    /// Whether the skin spans clearly more than a half turn at a corner of the trailing edge, which
    /// no smooth limit surface does: between the root and both sides of a swept wing.
    [[nodiscard]] bool tail_turns_back(int ring) const {
        const Vec3 at = ring_point(ring, 0);
        const Vec3 forward = ring_point(ring, 1) - at;
        return is_corner(ring * ring_.size()) &&
               geom::angle_between(ring_point(ring - 1, 0) - at, forward) +
                       geom::angle_between(forward, ring_point(ring + 1, 0) - at) >
                   std::numbers::pi + widest_past_half_turn_rad;
    }

    void crease_ring(int ring) {
        const int n = ring_.size();
        for (int j = 0; j < n; ++j)
            blocks_.creases.emplace_back(ring * n + j, ring * n + (j + 1) % n);
    }

    void add_end_face(const WingEnd& end, std::vector<int> corners) {
        const bool first = end.outward < 0.0;
        if (first) std::reverse(corners.begin(), corners.end());
        add_face(std::move(corners), first ? "root" : "tip");
    }

    /// Quads between both sides of a ring.
    void close(const WingEnd& end, int ring) {
        const int n = ring_.size(), last = ring_.of_side - 1 + (wing_.nose_line ? 1 : 0);
        const auto id = [&](int j) { return ring * n + (j + n) % n; };
        for (int j = 0; j < last; ++j) {
            std::vector<int> corners{id(j), id(j + 1)};
            if (ring_.across(j + 1) != j + 1) corners.push_back(id(ring_.across(j + 1)));
            if (ring_.across(j) != j) corners.push_back(id(ring_.across(j)));
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
        const int tail = ring * ring_.size(), nose = tail + ring_.of_side, last = ring_.of_side - 2;
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
            add_end_face(end, {at(k + 1), id(ring_.across(k + 1)), id(ring_.across(k)), at(k)});
        }
        blocks_.corners.push_back(tail);
    }

    const Wing& wing_;
    const geom::ModelSurface& reference_;
    RingColumns ring_;
    double tolerance_mm_;
    Poll& poll_;
    std::vector<double> shares_;
    std::vector<char> on_line_;  ///< one a section: a sharp or bent curve runs along it
    Blocks blocks_;
};

}  // namespace

Blocks wing_blocks(const Wing& wing, const geom::ModelSurface& reference,
                   const WingOptions& options, Poll& poll) {
    return WingRings(wing, reference, options, poll).run();
}

}  // namespace patchwright::cage
