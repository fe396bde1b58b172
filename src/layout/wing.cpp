#include "layout/wing.h"

#include "layout/wing_section.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace patchwright::layout {

using geom::Vec3;

namespace {

enum class EndKind { Lid, Open, Rounded };

struct End {
    EndKind kind = EndKind::Rounded;
    double extreme = 0.0;  ///< height where the body ends
    double ring = 0.0;     ///< height of the last ring that is a section
    double outward = 1.0;  ///< sign of the span's direction
};

// Fractions of the span.
constexpr double flat_rel = 2e-4, inside_rel = 2e-5, in_plane_rel = 3e-3, apart_rel = 0.01;

class WingLayout {
  public:
    WingLayout(const Body& body, const geom::ModelSurface& reference, const WingOptions& options,
               const Vec3& axis)
        : reference_(reference),
          options_(options),
          slicer_(body, axis),
          span_(slicer_.high() - slicer_.low()) {
        ends_[0].extreme = slicer_.low();
        ends_[1].extreme = slicer_.high();
        ends_[0].outward = -1.0;
    }

    std::optional<Blocks> run() {
        if (!is_wing()) return std::nullopt;
        for (End& end : ends_) {
            classify(end);
            if (!place_ring(end)) return std::nullopt;
        }
        for (const double height : stations()) {
            const auto section = section_at(height);
            if (!section || section->blunt != blunt_) return std::nullopt;
            sections_.push_back(*section);
        }
        share_columns();
        for (const WingSection& section : sections_) add_ring(section);
        for (const End& end : ends_) finish_end(end);
        connect();
        return std::move(blocks_);
    }

  private:
    [[nodiscard]] std::optional<WingSection> section_at(double height) const {
        return wing_section(slicer_.cut(height), reference_.features(), reference_);
    }

    bool is_wing() {
        if (!(span_ > 0.0)) return false;
        int blunt = 0, count = 0;
        double chords = 0.0;
        for (const double share : {0.08, 0.2, 0.35, 0.5, 0.65, 0.8, 0.92}) {
            const auto section = section_at(slicer_.low() + share * span_);
            if (!section) return false;
            blunt += section->blunt ? 1 : 0;
            chords += section->chord;
            ++count;
        }
        blunt_ = blunt > 0;
        return (blunt == 0 || blunt == count) && span_ > 0.4 * chords / count;
    }

    void classify(End& end) const {
        const occ::SurfaceMesh& mesh = *slicer_.body().mesh;
        const auto at_end = [&](int v) {
            return std::abs(slicer_.height(v) - end.extreme) < flat_rel * span_;
        };
        double lid = 0.0;
        std::map<std::pair<int, int>, int> uses;
        for (const int t : slicer_.body().triangles) {
            const auto& c = mesh.triangles[std::size_t(t)];
            for (std::size_t k = 0; k < 3; ++k)
                if (at_end(c[k]) && at_end(c[(k + 1) % 3]))
                    ++uses[std::minmax(c[k], c[(k + 1) % 3])];
            if (!at_end(c[0]) || !at_end(c[1]) || !at_end(c[2])) continue;
            const Vec3 a = mesh.points.row(c[0]), b = mesh.points.row(c[1]),
                       d = mesh.points.row(c[2]);
            lid += 0.5 * std::abs((b - a).cross(d - a).dot(slicer_.normal()));
        }
        const auto open =
            std::count_if(uses.begin(), uses.end(), [](const auto& u) { return u.second == 1; });
        const auto near = section_at(end.extreme - end.outward * 0.05 * span_);
        if (near && lid > 0.3 * near->chord * near->thickness) {
            end.kind = EndKind::Lid;
        } else if (open > 4 && lid == 0.0) {
            end.kind = EndKind::Open;
        }
    }

    bool place_ring(End& end) {
        end.ring = end.extreme - end.outward * inside_rel * span_;
        if (end.kind != EndKind::Rounded) return true;
        const auto whole = section_at(end.extreme - end.outward * 0.1 * span_);
        if (!whole) return false;
        // Where a line of the model runs around the body near the end, the tip starts there.
        const double reach = 1.5 * whole->thickness;
        std::optional<double> best;
        for (const double height : lines_around())
            if (std::abs(end.extreme - height) < reach && std::abs(end.extreme - height) > 0.0)
                if (!best || std::abs(end.extreme - height) > std::abs(end.extreme - *best))
                    best = height;
        for (double share = 0.3; !best && share < 4.0; share *= 1.25) {
            const double height = end.extreme - end.outward * share * whole->thickness;
            const auto section = section_at(height);
            if (section && section->thickness > 0.85 * whole->thickness) best = height;
        }
        if (!best) return false;
        end.ring = *best;
        return true;
    }

    /// Heights at which feature curves of any kind run around the body.
    [[nodiscard]] std::vector<double> lines_around() const {
        const auto& curves = reference_.features().curves;
        std::vector<double> heights;
        for (std::size_t i = 0; i < curves.size(); ++i) {
            double low = 1e300, high = -1e300;
            for (int k = 0; k <= 8; ++k) {
                const Vec3 p = reference_.point_on_curve(int(i), curves[i].length * k / 8.0).point;
                low = std::min(low, p.dot(slicer_.normal()));
                high = std::max(high, p.dot(slicer_.normal()));
            }
            if (high - low > in_plane_rel * span_) continue;
            const double height = 0.5 * (low + high);
            const auto section = section_at(height);
            if (section && curves[i].length > 0.3 * section->chord) heights.push_back(height);
        }
        std::sort(heights.begin(), heights.end());
        return heights;
    }

    [[nodiscard]] std::vector<double> stations() const {
        const double low = ends_[0].ring, high = ends_[1].ring;
        std::vector<double> fixed{low};
        for (const double h : lines_around())
            if (h - fixed.back() > apart_rel * span_ && high - h > apart_rel * span_)
                fixed.push_back(h);
        fixed.push_back(high);
        std::vector<double> result;
        for (std::size_t i = 0; i + 1 < fixed.size(); ++i) {
            const double a = fixed[i], b = fixed[i + 1];
            const int pieces = std::max(1, int(std::lround((b - a) / span_ * options_.spans)));
            for (int k = 0; k < pieces; ++k) result.push_back(a + (b - a) * k / pieces);
        }
        result.push_back(high);
        // Beside a short tip the last interval must not be much longer than the tip.
        const double tip_low = low - ends_[0].extreme, tip_high = ends_[1].extreme - high;
        if (ends_[1].kind == EndKind::Rounded && high - result[result.size() - 2] > 6.0 * tip_high)
            result.insert(result.end() - 1, high - 2.5 * tip_high);
        if (ends_[0].kind == EndKind::Rounded && result[1] - low > 6.0 * tip_low)
            result.insert(result.begin() + 1, low + 2.5 * tip_low);
        return result;
    }

    /// The same shares of the sides' lengths in all rings: dense at the nose, on which no line
    /// runs: its points lie where the section has turned by about 50 degrees.
    void share_columns() {
        std::vector<double> radii;
        for (const WingSection& s : sections_)
            radii.push_back(s.nose_radius / (0.5 * (s.length(0) + s.length(1))));
        std::nth_element(radii.begin(), radii.begin() + std::ptrdiff_t(radii.size() / 2),
                         radii.end());
        const double nose = std::clamp(0.9 * radii[radii.size() / 2], 0.003, 0.02);
        constexpr std::array<double, 7> usual{1.0, 0.825, 0.565, 0.385, 0.21, 0.105, 0.035};
        const int inner = options_.columns - 1;
        for (int j = 0; j < inner; ++j) {
            const double x = double(j) / (inner - 1) * (usual.size() - 1);
            const auto i = std::min(std::size_t(x), usual.size() - 2);
            shares_.push_back(1.0 - (usual[i] + (x - double(i)) * (usual[i + 1] - usual[i])));
        }
        shares_.push_back(1.0 - nose);
    }

    [[nodiscard]] int ring_size() const { return 2 * options_.columns - (blunt_ ? 0 : 1); }
    /// Side and number of the column of a ring's point.
    [[nodiscard]] std::pair<int, int> column(int j) const {
        return j < options_.columns ? std::pair(0, j) : std::pair(1, 2 * options_.columns - 1 - j);
    }
    /// The point across, on the other side; itself at a sharp trailing edge.
    [[nodiscard]] int across(int j) const {
        return blunt_ ? ring_size() - 1 - j : (ring_size() - j) % ring_size();
    }

    void add_ring(const WingSection& section) {
        for (int j = 0; j < ring_size(); ++j) {
            const auto [side, k] = column(j);
            const double share = shares_[std::size_t(k)];
            const Vec3 p = section.at(side, share);
            if (k == 0) {
                const auto feature = reference_.feature_point(p, geom::FeatureKind::Sharp);
                blocks_.points.push_back(feature ? feature->point : p);
                continue;
            }
            const Vec3 along = (section.at(side, share + 0.01) - section.at(side, share - 0.01)) *
                               (side == 0 ? 1.0 : -1.0);
            const Vec3 outward = along.cross(slicer_.normal()).normalized();
            blocks_.points.push_back(reference_.foot_point(p, outward).point);
        }
    }

    [[nodiscard]] int ring_count() const { return int(blocks_.points.size()) / ring_size(); }

    void finish_end(const End& end) {
        const int ring = end.outward < 0.0 ? 0 : int(sections_.size()) - 1;
        if (end.kind == EndKind::Rounded) {
            add_tip_ring(end, ring);
            return;
        }
        const auto kind =
            end.kind == EndKind::Lid ? geom::FeatureKind::Sharp : geom::FeatureKind::Free;
        for (int j = 0; j < ring_size(); ++j) {
            Vec3& p = blocks_.points[std::size_t(ring * ring_size() + j)];
            const auto feature = reference_.feature_point(p, kind);
            if (feature && feature->distance < 0.01 * span_) p = feature->point;
        }
    }

    [[nodiscard]] bool inside(const Vec3& p) const {
        const geom::FootPoint foot = reference_.foot_point(p);
        return (p - foot.point).dot(foot.normal) < 0.0;
    }

    /// How far the body goes on from a point inside, along the span.
    [[nodiscard]] double way_out(const Vec3& p, const Vec3& direction, double longest) const {
        double in = 0.0, out = longest;
        for (int i = 0; i < 24; ++i) {
            const double middle = 0.5 * (in + out);
            (inside(p + middle * direction) ? in : out) = middle;
        }
        return in;
    }

    /// A ring beyond a section: where the tip has turned half of its way to the end.
    void add_tip_ring(const End& end, int ring) {
        constexpr double up = 0.8, across_share = 0.6;
        const Vec3 direction = end.outward * slicer_.normal();
        const double longest = 1.2 * std::abs(end.extreme - end.ring);
        std::vector<Vec3> tip;
        for (int j = 0; j < ring_size(); ++j) {
            const auto at = [&](int i) {
                return blocks_.points[std::size_t(ring * ring_size() + i)];
            };
            const Vec3 own = at(j), middle = 0.5 * (own + at(across(j)));
            // At the trailing edge the middle is on the surface: a little forward it is not.
            const int k = column(j).second;
            const int next = k > 0 ? j : j == 0 ? 1 : j - 1;
            const Vec3 within =
                k > 0 ? middle : Vec3(0.8 * middle + 0.1 * at(next) + 0.1 * at(across(next)));
            const Vec3 rise = up * way_out(within, direction, longest) * direction;
            const Vec3 p = middle + rise + across_share * (own - middle);
            if (k == 0) {
                const auto feature = reference_.feature_point(p, geom::FeatureKind::Sharp);
                tip.push_back(feature ? feature->point : p);
            } else {
                const Vec3 side = own - middle;
                const Vec3 outward = side.norm() > 0.0
                                         ? Vec3((direction + side.normalized()).normalized())
                                         : direction;
                tip.push_back(reference_.foot_point(p, outward).point);
            }
        }
        const auto where = end.outward < 0.0 ? blocks_.points.begin() : blocks_.points.end();
        blocks_.points.insert(where, tip.begin(), tip.end());
    }

    void add_face(std::vector<int> corners, std::string group) {
        blocks_.faces.push_back(std::move(corners));
        blocks_.groups.push_back(std::move(group));
    }

    void connect() {
        const int n = ring_size(), rings = ring_count();
        const auto id = [&](int ring, int j) { return ring * n + (j + n) % n; };
        const WingSection& middle = sections_[sections_.size() / 2];
        const Vec3 up = middle.at(1, 0.5) - middle.at(0, 0.5);
        const bool upper_last = std::abs(up.z()) > 0.3 * up.norm() ? up.z() > 0.0 : up.y() > 0.0;
        for (int i = 0; i + 1 < rings; ++i) {
            for (int j = 0; j < n; ++j) {
                const bool strip = blunt_ && j == n - 1;
                const bool nose = j == options_.columns - 1;
                const bool last = j >= options_.columns;
                add_face({id(i, j), id(i, j + 1), id(i + 1, j + 1), id(i + 1, j)},
                         strip                ? "te"
                         : nose               ? "nose"
                         : last == upper_last ? "upper"
                                              : "lower");
            }
            blocks_.creases.emplace_back(id(i, 0), id(i + 1, 0));
            if (blunt_) blocks_.creases.emplace_back(id(i, n - 1), id(i + 1, n - 1));
        }
        for (const End& end : ends_) {
            if (end.kind == EndKind::Open) continue;
            const bool first = end.outward < 0.0;
            const int ring = first ? 0 : rings - 1;
            for (int j = 0; j + 1 < options_.columns; ++j) {
                std::vector<int> corners{id(ring, j), id(ring, j + 1), id(ring, across(j + 1))};
                if (across(j) != j) corners.push_back(id(ring, across(j)));
                if (first) std::reverse(corners.begin(), corners.end());
                add_face(std::move(corners), first ? "root" : "tip");
            }
            if (end.kind == EndKind::Lid) {
                for (int j = 0; j < n; ++j)
                    blocks_.creases.emplace_back(id(ring, j), id(ring, j + 1));
            } else if (blunt_) {
                blocks_.creases.emplace_back(id(ring, n - 1), id(ring, 0));
            }
        }
    }

    const geom::ModelSurface& reference_;
    const WingOptions& options_;
    Slicer slicer_;
    double span_;
    std::array<End, 2> ends_;
    bool blunt_ = false;
    std::vector<WingSection> sections_;
    std::vector<double> shares_;
    Blocks blocks_;
};

/// Directions that the span may have: across flat lids first, then the axes, longest first.
std::vector<Vec3> possible_axes(const Body& body) {
    const occ::SurfaceMesh& mesh = *body.mesh;
    geom::Box3 box;
    for (const int t : body.triangles)
        for (const int v : mesh.triangles[std::size_t(t)]) box.add(mesh.points.row(v).transpose());
    std::map<int, std::pair<Vec3, double>> faces;  // area vector and area by face
    for (const int t : body.triangles) {
        const auto& c = mesh.triangles[std::size_t(t)];
        const Vec3 a = mesh.points.row(c[0]), b = mesh.points.row(c[1]), d = mesh.points.row(c[2]);
        const Vec3 area = 0.5 * (b - a).cross(d - a);
        auto& sum = faces.try_emplace(mesh.faces[std::size_t(t)], Vec3::Zero(), 0.0).first->second;
        sum.first += area;
        sum.second += area.norm();
    }
    std::vector<Vec3> axes;
    const auto add = [&](Vec3 axis) {
        for (const Vec3& other : axes)
            if (std::abs(axis.dot(other)) > 1.0 - 1e-6) return;
        // The same direction whichever lid it comes from.
        int largest = 0;
        axis.cwiseAbs().maxCoeff(&largest);
        axes.push_back(axis[largest] < 0.0 ? Vec3(-axis) : axis);
    };
    for (const auto& [face, sum] : faces)
        if (sum.first.norm() > (1.0 - 1e-9) * sum.second) add(sum.first.normalized());
    const Vec3 extent = box.max - box.min;
    std::array<int, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int a, int b) { return extent[a] > extent[b]; });
    for (const int k : order) add(Vec3::Unit(k));
    return axes;
}

}  // namespace

std::optional<Blocks> wing_blocks(const Body& body, const geom::ModelSurface& reference,
                                  const WingOptions& options) {
    for (const Vec3& axis : possible_axes(body))
        if (auto blocks = WingLayout(body, reference, options, axis).run()) return blocks;
    return std::nullopt;
}

}  // namespace patchwright::layout
