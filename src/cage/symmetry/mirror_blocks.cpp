#include "cage/symmetry/mirror_blocks.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

using Edge = std::pair<int, int>;

// Of the diagonal: points that are nearer to each other are one.
constexpr double same_place_rel = 1e-6;

class Mirror {
  public:
    Mirror(BlocksOnCurves& made, const HalfSurface& half, double within_mm, Poll& poll)
        : blocks_(made.blocks),
          curves_(made.curves),
          half_(half),
          within_(within_mm),
          poll_(poll) {}

    void run() {
        const std::set<Edge> on_plane = edges_on_plane();
        add_points(on_plane);
        const EdgeCurves own = std::exchange(curves_, {});
        for (const auto& [edge, curve] : own) {
            poll_();
            if (on_plane.contains(edge)) {
                const int sharp = sharp_curve_at(edge, curve);
                if (sharp < 0) continue;
                curves_[edge] = sharp;
                blocks_.creases.push_back(edge);
            } else if (!half_.is_section(curve)) {
                curves_[edge] = curve;
                curves_[image(edge)] = image_of_curve(curve, edge);
            }
        }
        add_images(on_plane);
        set_corners_on_plane();
    }

  private:
    [[nodiscard]] const Vec3& point(int v) const { return blocks_.points[at(v)]; }
    [[nodiscard]] Edge image(const Edge& e) const {
        return std::minmax(image_[at(e.first)], image_[at(e.second)]);
    }

    /// Border edges of the half that the plane makes.
    [[nodiscard]] std::set<Edge> edges_on_plane() const {
        std::map<Edge, int> faces_of;
        for (const std::vector<int>& face : blocks_.faces)
            for (std::size_t k = 0; k < face.size(); ++k)
                ++faces_of[std::minmax(face[k], face[(k + 1) % face.size()])];
        const auto on = [&](int v) { return std::abs(half_.plane().height(point(v))) <= within_; };
        std::set<Edge> result;
        for (const auto& [edge, count] : faces_of)
            if (count == 1 && on(edge.first) && on(edge.second)) result.insert(edge);
        return result;
    }

    void add_points(const std::set<Edge>& on_plane) {
        const int count = int(blocks_.points.size());
        image_.assign(at(count), -1);
        for (const auto& [a, b] : on_plane)
            for (const int v : {a, b}) {
                blocks_.points[at(v)] = half_.plane().onto(point(v));
                image_[at(v)] = v;
            }
        for (int v = 0; v < count; ++v) {
            if (image_[at(v)] == v) continue;
            image_[at(v)] = int(blocks_.points.size());
            blocks_.points.push_back(half_.plane().mirrored(point(v)));
        }
    }

    void add_images(const std::set<Edge>& on_plane) {
        const std::size_t faces = blocks_.faces.size(), creases = blocks_.creases.size(),
                          corners = blocks_.corners.size();
        for (std::size_t f = 0; f < faces; ++f) {
            std::vector<int> face;
            for (const int v : blocks_.faces[f]) face.push_back(image_[at(v)]);
            std::reverse(face.begin(), face.end());
            blocks_.faces.push_back(std::move(face));
        }
        for (std::size_t i = 0; i < creases; ++i) {
            const Edge edge = std::minmax(blocks_.creases[i].first, blocks_.creases[i].second);
            if (!on_plane.contains(edge)) blocks_.creases.push_back(image(edge));
        }
        for (std::size_t i = 0; i < corners; ++i)
            if (const int v = blocks_.corners[i]; image_[at(v)] != v)
                blocks_.corners.push_back(image_[at(v)]);
    }

    /// Corners of the whole, but for ends of single creases within smooth surfaces.
    void set_corners_on_plane() {
        std::map<int, int> creases_at;
        for (const auto& [a, b] : blocks_.creases) {
            ++creases_at[a];
            ++creases_at[b];
        }
        std::erase_if(blocks_.corners,
                      [&](int v) { return at(v) < image_.size() && image_[at(v)] == v; });
        const double same_mm = same_place_rel * half_.whole().size();
        for (std::size_t v = 0; v < image_.size(); ++v) {
            if (image_[v] != int(v) || creases_at[int(v)] == 1) continue;
            for (const geom::FeatureCorner& corner : half_.whole().features().corners)
                if ((corner.point - blocks_.points[v]).norm() <= same_mm) {
                    blocks_.corners.push_back(int(v));
                    break;
                }
        }
    }

    /// Three points of an edge, on its curve.
    [[nodiscard]] std::array<Vec3, 3> points_along(const Edge& edge, int curve) const {
        const Vec3 middle = 0.5 * (point(edge.first) + point(edge.second));
        return {point(edge.first), half_.nearest_on_curve(curve, middle).point, point(edge.second)};
    }

    /// The whole's curve of one kind that runs along these points nearest to them, and how far it
    /// is off.
    [[nodiscard]] std::pair<int, double> nearest_curve(const std::array<Vec3, 3>& points,
                                                       geom::FeatureKind kind) const {
        constexpr double along = 0.5;  // of the points' own distance
        std::pair<int, double> best{-1, base::infinity};
        const auto& curves = half_.whole().features().curves;
        for (int c = 0; c < int(curves.size()); ++c) {
            if (curves[at(c)].kind != kind) continue;
            std::array<geom::FeaturePoint, 3> feet;
            double most = 0.0;
            for (std::size_t k = 0; k < 3; ++k) {
                feet[k] = half_.whole().nearest_on_curve(c, points[k]);
                most = std::max(most, feet[k].distance);
            }
            const double way = (feet[2].point - feet[0].point).norm();
            if (most < best.second && way > along * (points[2] - points[0]).norm())
                best = {c, most};
        }
        return best;
    }

    [[nodiscard]] int sharp_curve_at(const Edge& edge, int curve) const {
        const auto [sharp, distance] =
            nearest_curve(points_along(edge, curve), geom::FeatureKind::Sharp);
        return distance <= within_ ? sharp : -1;
    }

    int image_of_curve(int curve, const Edge& edge) {
        const auto known = image_of_curve_.find(curve);
        if (known != image_of_curve_.end()) return known->second;
        auto points = points_along(edge, curve);
        for (Vec3& p : points) p = half_.plane().mirrored(p);
        const geom::FeatureKind kind = half_.features().curves[at(curve)].kind;
        return image_of_curve_[curve] = nearest_curve(points, kind).first;
    }

    Blocks& blocks_;
    EdgeCurves& curves_;
    const HalfSurface& half_;
    double within_;
    Poll& poll_;
    std::vector<int> image_;  ///< one a point of the half: itself on the plane
    std::map<int, int> image_of_curve_;
};

}  // namespace

BlocksOnCurves with_mirror_image(BlocksOnCurves made, const HalfSurface& half, double within_mm,
                                 Poll& poll) {
    Mirror(made, half, within_mm, poll).run();
    return made;
}

}  // namespace patchwright::cage
