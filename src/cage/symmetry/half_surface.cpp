#include "cage/symmetry/half_surface.h"

#include "cage/remesh/mesh_part.h"
#include "geom/angle.h"
#include "geom/editable_mesh.h"

#include <patchwright/base/numbers.h>
#include <patchwright/geom/nearest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace patchwright::cage {

using base::at;
using geom::FeaturePoint;
using geom::FootPoint;
using geom::Vec3;

namespace {

// Of the diagonal: vertices nearer to the plane lie on it, as those of faces that end there.
constexpr double on_plane_rel = 1e-6;

/// On the plane and on the model: foot points of a symmetric surface stay on the plane.
Vec3 onto_both(const Vec3& p, int curve, const geom::ModelSurface& whole,
               const MirrorPlane& plane) {
    return plane.onto(curve >= 0 ? whole.nearest_on_curve(curve, p).point
                                 : whole.foot_point(p).point);
}

}  // namespace

/// Cuts the body's triangles and finds the lines of the section.
class HalfSurface::Builder {
  public:
    Builder(const SurfaceBody& body, HalfSurface& half, Poll& poll)
        : half_(half),
          whole_(half.whole_),
          plane_(half.plane_),
          cut_(part_of(body, std::vector<char>(whole_.features().curves.size(), 1))),
          within_(on_plane_rel * whole_.size()),
          poll_(poll) {}

    /// @return whether the half is a surface
    bool build() {
        part_triangles();
        take_half();
        if (touches_) return false;
        half_.features_ = whole_.features();
        half_.first_section_ = int(half_.features_.curves.size());
        set_corners();
        find_sections();
        for (Eigen::Index i = 0; i < half_.mesh_.points.rows(); ++i)
            half_.bounds_.add(Vec3(half_.mesh_.points.row(i)));
        return true;
    }

  private:
    void part_triangles() {
        for (int v = 0; v < cut_.vertex_count(); ++v) {
            const double h = plane_.height(cut_.point(v));
            const bool on = std::abs(h) <= within_;
            if (on) cut_.move(v, plane_.onto(cut_.point(v)));
            side_.push_back(on ? 0 : h > 0.0 ? 1 : -1);
        }
        std::set<std::pair<int, int>> crossing;
        for (int t = 0; t < cut_.triangle_count(); ++t) {
            const auto& c = cut_.triangle(t);
            for (std::size_t k = 0; k < 3; ++k)
                if (side_[at(c[k])] * side_[at(c[(k + 1) % 3])] < 0)
                    crossing.insert(std::minmax(c[k], c[(k + 1) % 3]));
        }
        for (const auto& [a, b] : crossing) {
            poll_();
            const double ha = plane_.height(cut_.point(a)), hb = plane_.height(cut_.point(b));
            const Vec3 p = cut_.point(a) + ha / (ha - hb) * (cut_.point(b) - cut_.point(a));
            const geom::EdgeSides s = cut_.sides(a, b);
            cut_.split(a, b, onto_both(p, cut_.curve(s.triangle[0], s.side[0]), whole_, plane_));
            side_.push_back(0);
        }
    }

    [[nodiscard]] bool is_mine(int t) const {
        const auto& c = cut_.triangle(t);
        const int sum = side_[at(c[0])] + side_[at(c[1])] + side_[at(c[2])];
        // All of a triangle may be on the plane, as within a narrow face.
        return sum > 0 || (sum == 0 && cut_.area_vector(t).dot(plane_.normal) > 0.0);
    }

    /// A step of the border that the plane makes, and the whole's curve under it or -1.
    struct Step {
        int to, curve;
    };

    void take_half() {
        std::vector<int> number(at(cut_.vertex_count()), -1);
        std::vector<Vec3> points;
        geom::SurfaceMesh& mesh = half_.mesh_;
        for (int t = 0; t < cut_.triangle_count(); ++t) {
            if (!is_mine(t)) continue;
            std::array<int, 3> corners = cut_.triangle(t);
            for (int& v : corners) {
                int& n = number[at(v)];
                if (n < 0) {
                    n = int(points.size());
                    points.push_back(cut_.point(v));
                    mesh.corners.push_back(cut_.corner(v));
                }
                v = n;
            }
            for (int k = 0; k < 3; ++k) add_side(t, k, corners[at(k)], corners[at((k + 1) % 3)]);
            mesh.triangles.push_back(corners);
            mesh.faces.push_back(cut_.face(t));
        }
        mesh.points.resize(Eigen::Index(points.size()), 3);
        for (std::size_t i = 0; i < points.size(); ++i)
            mesh.points.row(Eigen::Index(i)) = points[i];
    }

    /// @param a, b  ends of the side in the half
    void add_side(int t, int k, int a, int b) {
        const auto& c = cut_.triangle(t);
        const geom::EdgeSides s = cut_.sides(c[at(k)], c[at((k + 1) % 3)]);
        const int beyond = s.triangle[0] == t ? s.triangle[1] : s.triangle[0];
        const int curve = cut_.curve(t, k);
        if (beyond >= 0 && is_mine(beyond)) {
            if (curve >= 0 && t < beyond) add_feature(a, b, curve);
            return;
        }
        const int along = beyond < 0 ? free_ : is_smooth(curve) ? -1 : curve;
        touches_ = touches_ || !border_.emplace(a, Step{b, along}).second;
        if (beyond < 0) add_feature(a, b, curve);
    }

    void add_feature(int a, int b, int curve) {
        half_.mesh_.features.push_back({std::min(a, b), std::max(a, b), curve});
        if (is_smooth(curve)) return;
        on_hard_features_.insert(a);
        on_hard_features_.insert(b);
    }

    [[nodiscard]] bool is_smooth(int curve) const {
        return curve < 0 || whole_.features().curves[at(curve)].kind == geom::FeatureKind::Smooth;
    }

    /// Corners of the border are where sharp or free features end at it, and corners of the whole
    /// where it turns; others of the whole, as the nose of a swept wing, are none of the half.
    void set_corners() {
        std::map<int, int> from;
        for (const auto& [a, step] : border_)
            if (step.curve != free_) from[step.to] = a;
        const auto point = [&](int v) { return Vec3(half_.mesh_.points.row(v)); };
        for (const auto& [v, step] : border_) {
            const auto before = from.find(v);
            if (step.curve == free_ || before == from.end()) continue;
            const double turn =
                geom::angle_between(point(v) - point(before->second), point(step.to) - point(v));
            int& corner = half_.mesh_.corners[at(v)];
            const bool is_end = on_hard_features_.contains(v);
            if (!is_end && turn <= geom::default_sharp_angle_rad) corner = -1;
            if (!is_end || corner >= 0) continue;
            corner = int(half_.features_.corners.size());
            half_.features_.corners.push_back({.point = point(v)});
        }
    }

    /// Lines of the section between corners.
    void find_sections() {
        std::erase_if(border_, [](const auto& step) { return step.second.curve == free_; });
        std::set<int> reached;
        for (const auto& [from, step] : border_) reached.insert(step.to);
        const auto is_end = [&](int v) {
            return !reached.contains(v) || !border_.contains(v) || half_.mesh_.corners[at(v)] >= 0;
        };
        for (const auto& [from, step] : border_)
            for (const int v : {from, step.to})
                if (is_end(v)) ends_.insert(v);
        for (const int from : ends_)
            if (border_.contains(from)) add_section(from);
        while (!border_.empty()) add_section(border_.begin()->first);
    }

    void add_section(int from) {
        Section section;
        const int number = int(half_.features_.curves.size());
        int v = from;
        section.line.push_back(half_.mesh_.points.row(v));
        do {
            const auto step = border_.find(v);
            const int to = step->second.to;
            half_.mesh_.features.push_back({std::min(v, to), std::max(v, to), number});
            section.line.push_back(half_.mesh_.points.row(to));
            section.curves.push_back(step->second.curve);
            border_.erase(step);
            v = to;
        } while (v != from && !ends_.contains(v));
        geom::FeatureCurve curve;
        curve.kind = geom::FeatureKind::Free;
        section.arc_lengths = geom::arc_lengths(section.line);
        curve.length = section.arc_lengths.back();
        curve.closed = v == from;
        curve.start_corner = half_.mesh_.corners[at(from)];
        curve.end_corner = half_.mesh_.corners[at(v)];
        curve.start = section.line.front();
        curve.end = section.line.back();
        half_.features_.curves.push_back(curve);
        half_.sections_.push_back(std::move(section));
    }

    static constexpr int free_ = -2;  ///< of a step where the whole ends

    HalfSurface& half_;
    const geom::ModelSurface& whole_;
    const MirrorPlane& plane_;
    geom::EditableMesh cut_;
    double within_;
    Poll& poll_;
    std::vector<int> side_;           ///< of the plane, by vertex of the cut triangles: 1, 0 or -1
    std::map<int, Step> border_;      ///< by the vertex of the half that the step starts from
    bool touches_ = false;            ///< two steps start from one vertex
    std::set<int> on_hard_features_;  ///< vertices of the half on sharp or free curves
    std::set<int> ends_;              ///< of lines of the section
};

std::unique_ptr<HalfSurface> HalfSurface::of(const SurfaceBody& body,
                                             const geom::ModelSurface& reference,
                                             const MirrorPlane& plane, Poll& poll) {
    std::unique_ptr<HalfSurface> half(new HalfSurface(reference, plane));
    if (!Builder(body, *half, poll).build()) return nullptr;
    return half;
}

SurfaceBody HalfSurface::body() const {
    SurfaceBody body{.mesh = &mesh_};
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) body.triangles.push_back(int(t));
    return body;
}

FootPoint HalfSurface::foot_point(const Vec3& query, const std::optional<Vec3>& side) const {
    const bool beyond = plane_.height(query) < 0.0;
    std::optional<Vec3> facing = side;
    if (side && beyond) facing = plane_.mirrored_direction(*side);
    FootPoint foot = whole_.foot_point(on_this_side(query), facing);
    if (plane_.height(foot.point) < 0.0) {
        foot.point = plane_.mirrored(foot.point);
        foot.normal = plane_.mirrored_direction(foot.normal);
    }
    return foot;
}

std::optional<geom::Curvature> HalfSurface::curvature(const FootPoint& foot) const {
    auto bend = whole_.curvature(foot);
    if (bend && plane_.height(whole_.point_on_face(foot.face, foot.uv).point) < 0.0)
        for (Vec3& d : bend->direction) d = plane_.mirrored_direction(d);
    return bend;
}

FeaturePoint HalfSurface::on_section(int curve, const Vec3& near, std::size_t step) const {
    const Section& s = section(curve);
    const Vec3 along = s.line[step + 1] - s.line[step];
    FeaturePoint result;
    result.point = onto_both(near, s.curves[step], whole_, plane_);
    result.feature = curve;
    result.arc_length = s.arc_lengths[step] + (near - s.line[step]).norm();
    result.tangent = along.normalized();
    return result;
}

FeaturePoint HalfSurface::nearest_on_curve(int curve, const Vec3& asked,
                                           const std::optional<geom::ArcRange>& within) const {
    const Vec3 query = on_this_side(asked);
    if (!is_section(curve)) {
        const FeaturePoint p = whole_.nearest_on_curve(curve, query, within);
        // A curve that crosses the plane is its own mirror image.
        return plane_.height(p.point) < 0.0
                   ? whole_.nearest_on_curve(curve, plane_.mirrored(p.point), within)
                   : p;
    }
    const Section& s = section(curve);
    const double length = s.arc_lengths.back();
    const geom::ArcRange piece = within.value_or(geom::ArcRange{0.0, length});
    Vec3 best = s.line.front();
    std::size_t step = 0;
    double least = base::infinity;
    for (std::size_t i = 0; i + 1 < s.line.size(); ++i) {
        const Vec3 along = s.line[i + 1] - s.line[i];
        const double size = s.arc_lengths[i + 1] - s.arc_lengths[i];
        // A piece of a closed line may run across its start.
        for (const double turn : {0.0, -length, length}) {
            if (turn != 0.0 && !features_.curves[at(curve)].closed) break;
            const double from = piece.from - turn - s.arc_lengths[i],
                         to = piece.to - turn - s.arc_lengths[i];
            if (from > size || to < 0.0) continue;
            const Vec3 unit = size > 0.0 ? Vec3(along / size) : Vec3::Zero();
            const Vec3 p = geom::nearest_on_segment(query, s.line[i] + std::max(from, 0.0) * unit,
                                                    s.line[i] + std::min(to, size) * unit)
                               .point;
            if ((query - p).norm() >= least) continue;
            least = (query - p).norm();
            best = p;
            step = i;
        }
    }
    FeaturePoint result = on_section(curve, best, step);
    result.distance = (query - result.point).norm();
    return result;
}

FeaturePoint HalfSurface::point_on_curve(int curve, double arc_length) const {
    if (!is_section(curve)) return whole_.point_on_curve(curve, arc_length);
    const Section& s = section(curve);
    const double length = s.arc_lengths.back();
    if (features_.curves[at(curve)].closed) arc_length -= length * std::floor(arc_length / length);
    arc_length = std::clamp(arc_length, 0.0, length);
    const auto next =
        std::upper_bound(s.arc_lengths.begin() + 1, s.arc_lengths.end() - 1, arc_length);
    const auto step = std::size_t(next - s.arc_lengths.begin()) - 1;
    const double size = s.arc_lengths[step + 1] - s.arc_lengths[step];
    const double share = size > 0.0 ? (arc_length - s.arc_lengths[step]) / size : 0.0;
    return on_section(curve, (1.0 - share) * s.line[step] + share * s.line[step + 1], step);
}

std::optional<FeaturePoint> HalfSurface::feature_point(const Vec3& asked,
                                                       geom::FeatureKind kind) const {
    const Vec3 query = on_this_side(asked);
    std::optional<FeaturePoint> best = whole_.feature_point(query, kind);
    if (kind != geom::FeatureKind::Free) return best;
    for (int curve = first_section_; curve < int(features_.curves.size()); ++curve) {
        const FeaturePoint p = nearest_on_curve(curve, query);
        if (!best || p.distance < best->distance) best = p;
    }
    return best;
}

std::vector<geom::SurfaceSample> HalfSurface::sample(int count) const {
    std::vector<geom::SurfaceSample> samples = whole_.sample(2 * count);
    std::erase_if(samples, [&](const auto& s) { return plane_.height(s.point) < 0.0; });
    return samples;
}

std::vector<geom::SurfacePiece> HalfSurface::pieces() const {
    std::vector<geom::SurfacePiece> pieces = whole_.pieces();
    std::erase_if(pieces, [&](const geom::SurfacePiece& piece) {
        return std::all_of(piece.uv.begin(), piece.uv.end(), [&](const Eigen::Vector2d& uv) {
            return plane_.height(whole_.point_on_face(piece.face, uv).point) < 0.0;
        });
    });
    return pieces;
}

}  // namespace patchwright::cage
