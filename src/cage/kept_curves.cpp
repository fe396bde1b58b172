#include "cage/kept_curves.h"

#include <patchwright/geom/curve_ends.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace patchwright::cage {

namespace {

// Radius as a fraction of the diagonal. Edges of cages are at least 8e-3 of the diagonal long
// (SizeOptions::least_rel), which is more than a quarter turn of a smaller radius can hold: such a
// rounding becomes a line of the cage instead.
constexpr double tight_radius_rel = 6e-3;

/// Whether the surface is rounded too tightly across a curve for faces of a cage, on most of it.
bool runs_along_tight_rounding(int curve, const geom::ModelSurface& reference, Poll& poll) {
    constexpr int samples = 9;
    const double length = reference.features().curves[std::size_t(curve)].length;
    const double tightest = tight_radius_rel * reference.size();
    int tight = 0;
    for (int k = 0; k < samples; ++k) {
        poll();
        const auto at = reference.point_on_curve(curve, length * (k + 0.5) / samples);
        const auto bend = reference.curvature(reference.foot_point(at.point));
        if (!bend) continue;
        double across = 0.0;
        for (std::size_t j = 0; j < 2; ++j) {
            const double along = bend->direction[j].dot(at.tangent);
            across += bend->value[j] * (1.0 - along * along);
        }
        tight += std::abs(across) * tightest > 1.0 ? 1 : 0;
    }
    return 2 * tight > samples;
}

/// Follows kept curves that end within the surface along smooth ones.
class ContinuationFinder {
  public:
    ContinuationFinder(const geom::ModelSurface& reference, std::vector<char>& kept)
        : reference_(reference),
          same_mm_(same_place_rel * reference.size()),
          ends_(geom::curve_ends(reference.features(), same_mm_)),
          at_place_(ends_.points.size()),
          kept_(kept) {
        for (std::size_t c = 0; c < ends_.places.size(); ++c)
            for (int k = 0; k < 2; ++k)
                if (const int place = ends_.places[c][std::size_t(k)]; place >= 0)
                    at_place_[std::size_t(place)].push_back({int(c), k});
    }

    void run() {
        for (std::size_t place = 0; place < at_place_.size(); ++place)
            if (kept_at(int(place)) == 1) follow(int(place));
    }

  private:
    struct End {
        int curve = -1, end = 0;  ///< 0: its start
    };

    [[nodiscard]] bool is_kept(int curve) const { return kept_[std::size_t(curve)] != 0; }

    [[nodiscard]] std::ptrdiff_t kept_at(int place) const {
        const auto& all = at_place_[std::size_t(place)];
        return std::count_if(all.begin(), all.end(),
                             [&](const End& e) { return is_kept(e.curve); });
    }

    /// Along the curve, away from its end.
    [[nodiscard]] geom::Vec3 direction(const End& e) const {
        const double length = reference_.features().curves[std::size_t(e.curve)].length;
        const geom::Vec3 t = reference_.point_on_curve(e.curve, e.end == 0 ? 0.0 : length).tangent;
        return e.end == 0 ? t : geom::Vec3(-t);
    }

    [[nodiscard]] bool on_sharp_or_free(const geom::Vec3& p) const {
        for (const auto kind : {geom::FeatureKind::Sharp, geom::FeatureKind::Free}) {
            const auto near = reference_.feature_point(p, kind);
            if (near && near->distance < same_mm_) return true;
        }
        return false;
    }

    /// The curve that goes on straightest from a place.
    [[nodiscard]] End straightest(int place, const geom::Vec3& ahead) const {
        End best;
        double most = std::cos(most_turn_rad);
        for (const End& e : at_place_[std::size_t(place)]) {
            if (is_kept(e.curve)) continue;
            const double cosine = direction(e).dot(ahead);
            if (cosine <= most) continue;
            most = cosine;
            best = e;
        }
        return best;
    }

    void follow(int place) {
        const auto& all = at_place_[std::size_t(place)];
        End last =
            *std::find_if(all.begin(), all.end(), [&](const End& e) { return is_kept(e.curve); });
        std::vector<int> chain;
        for (;;) {
            const End next = straightest(place, -direction(last));
            if (next.curve < 0) break;
            kept_[std::size_t(next.curve)] = 1;
            chain.push_back(next.curve);
            last = {next.curve, 1 - next.end};
            place = ends_.places[std::size_t(next.curve)][std::size_t(last.end)];
            if (kept_at(place) > 1 || on_sharp_or_free(ends_.points[std::size_t(place)])) return;
        }
        for (const int curve : chain) kept_[std::size_t(curve)] = 0;
    }

    // 30 degrees.
    static constexpr double most_turn_rad = 0.52;
    // Of the diagonal: ends that are nearer to each other are in one place.
    static constexpr double same_place_rel = 1e-6;

    const geom::ModelSurface& reference_;
    double same_mm_;
    geom::CurveEnds ends_;
    std::vector<std::vector<End>> at_place_;
    std::vector<char>& kept_;
};

}  // namespace

std::vector<char> kept_curves(const geom::ModelSurface& reference, Lines lines, Poll& poll) {
    // 6 degrees, a third of what is sharp: triangles across such a curve would smooth it away.
    constexpr double slight_bend_rad = 0.1;
    // Of the diagonal: shorter smooth curves are seams between small faces.
    constexpr double shortest_smooth_rel = 0.02;
    const double diagonal = reference.size();
    const auto& curves = reference.features().curves;
    std::vector<char> kept;
    for (std::size_t i = 0; i < curves.size(); ++i) {
        const geom::FeatureCurve& curve = curves[i];
        const bool is_long = curve.length > shortest_smooth_rel * diagonal;
        const bool bends =
            lines == Lines::OfTriangles && curve.greatest_angle_rad > slight_bend_rad;
        kept.push_back(curve.kind != geom::FeatureKind::Smooth ||
                       (is_long && (bends || runs_along_tight_rounding(int(i), reference, poll))));
    }
    return kept;
}

void keep_continuations(const geom::ModelSurface& reference, std::vector<char>& kept) {
    ContinuationFinder(reference, kept).run();
}

}  // namespace patchwright::cage
