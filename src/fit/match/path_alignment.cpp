#include "fit/match/path_alignment.h"

#include <patchwright/base/numbers.h>
#include <patchwright/geom/nearest.h>

#include <algorithm>
#include <cmath>

namespace patchwright::fit {

using base::infinity;
using geom::FeaturePoint;
using geom::Vec3;

namespace {

// Places for each point of the chain, but not more than there is time for.
constexpr double places_per_point = 2.0;
constexpr double max_places = 4096.0;
// Cosine of the turn between two places above which there are more between them, so that both sides
// of a narrow end have their own; down to this part of the path's length.
constexpr double max_turn_cosine = 0.5, min_place_step_rel = 1e-7;
// How far along the path targets follow their neighbours, in parts of the distance from it: what
// lies a distance off says nothing of smaller features, as the end of a blunt trailing edge.
constexpr double elastic_length_rel = 2.0;
// A closed chain may have slid along its path by this share of it.
constexpr double slide_share = 0.25;

/// Of a point from a segment.
double squared_distance(const Vec3& a, const Vec3& b, const Vec3& q) {
    return (geom::nearest_on_segment(q, a, b).point - q).squaredNorm();
}

}  // namespace

PathAlignment::PathAlignment(const geom::ReferenceSurface& reference, FeaturePath path, bool closed,
                             std::size_t points)
    : reference_(reference), path_(std::move(path)), closed_(closed), start_{0.0} {
    for (const FeaturePiece& piece : path_)
        start_.push_back(start_.back() + piece.range.to - piece.range.from);
    const double length = start_.back();
    const double step = length / std::min(places_per_point * double(points), max_places);
    for (std::size_t k = 0; k < path_.size(); ++k) add_places(k, step);
    if (!closed) return;
    const std::vector<Place> turn = places_;
    const auto add = [&](const Place& place, double arc) {
        places_.push_back(place);
        places_.back().arc = arc;
    };
    places_.clear();
    for (const Place& p : turn)
        if (p.arc > (1.0 - slide_share) * length) add(p, p.arc - length);
    for (const Place& p : turn) add(p, p.arc);
    for (const Place& p : turn)
        if (p.arc < slide_share * length) add(p, p.arc + length);
}

PathAlignment::Place PathAlignment::place_at(std::size_t k, double arc) const {
    const FeaturePiece& piece = path_[k];
    const double s = arc - start_[k];
    const FeaturePoint p = reference_.point_on_curve(
        piece.curve, piece.reversed ? piece.range.to - s : piece.range.from + s);
    return {arc, p.point, p.tangent};
}

void PathAlignment::add_places(std::size_t k, double step) {
    const double length = start_[k + 1] - start_[k];
    const int count = std::max(1, int(std::ceil(length / step)));
    const double least = min_place_step_rel * start_.back();
    std::vector<Place> waiting;  // the next one last
    for (int i = count; i >= 0; --i) waiting.push_back(place_at(k, start_[k] + length * i / count));
    Place here = waiting.back();
    waiting.pop_back();
    places_.push_back(here);
    while (!waiting.empty()) {
        const Place& next = waiting.back();
        const bool turns = here.tangent.dot(next.tangent) < max_turn_cosine;
        if (turns && next.arc - here.arc > least) {
            waiting.push_back(place_at(k, 0.5 * (here.arc + next.arc)));
            continue;
        }
        here = next;
        waiting.pop_back();
        places_.push_back(here);
    }
}

std::vector<std::size_t> PathAlignment::segments_of(const geom::Polyline& chain) const {
    const std::size_t count = places_.size() - 1;
    std::vector<double> least(count, 0.0);  // with the last point at this segment or before
    std::vector<bool> here(count * chain.size(), false);  // that least is at the segment itself
    for (std::size_t i = 0; i < chain.size(); ++i) {
        double before = infinity;
        for (std::size_t j = 0; j < count; ++j) {
            const double cost =
                least[j] + squared_distance(places_[j].point, places_[j + 1].point, chain[i]);
            here[i * count + j] = cost < before;
            least[j] = before = std::min(before, cost);
        }
    }
    std::vector<std::size_t> result(chain.size());
    std::size_t j = count - 1;
    for (std::size_t i = chain.size(); i-- > 0;) {
        while (!here[i * count + j]) --j;
        result[i] = j;
    }
    return result;
}

PathAlignment::Hit PathAlignment::nearest_between(double from, double to, const Vec3& q) const {
    Hit best;
    best.point.distance = infinity;
    const double whole = start_.back();
    for (const double turn : {-whole, 0.0, whole}) {
        for (std::size_t k = 0; k < path_.size(); ++k) {
            const FeaturePiece& piece = path_[k];
            const double first = std::max(from - turn, start_[k]) - start_[k];
            const double last = std::min(to - turn, start_[k + 1]) - start_[k];
            if (!(last > first)) continue;
            const geom::ArcRange range =
                piece.reversed ? geom::ArcRange{piece.range.to - last, piece.range.to - first}
                               : geom::ArcRange{piece.range.from + first, piece.range.from + last};
            const FeaturePoint hit = reference_.nearest_on_curve(piece.curve, q, range);
            if (!(hit.distance < best.point.distance)) continue;
            // On a closed curve by whole turns to where the piece is.
            const double length = reference_.features().curves[std::size_t(piece.curve)].length;
            const double middle = 0.5 * (range.from + range.to);
            const double s =
                hit.arc_length + std::round((middle - hit.arc_length) / length) * length;
            const double along = piece.reversed ? piece.range.to - s : s - piece.range.from;
            best = {hit, turn + start_[k] + std::clamp(along, first, last)};
        }
    }
    return best;
}

FeaturePoint PathAlignment::point_at(double arc, const Vec3& q) const {
    const double whole = start_.back();
    if (closed_) arc -= std::floor(arc / whole) * whole;
    const auto next = std::upper_bound(start_.begin() + 1, start_.end() - 1, arc);
    const auto k = std::size_t(next - start_.begin()) - 1;
    const FeaturePiece& piece = path_[k];
    const double s = std::clamp(arc, 0.0, whole) - start_[k];
    FeaturePoint p = reference_.point_on_curve(
        piece.curve, piece.reversed ? piece.range.to - s : piece.range.from + s);
    p.distance = (p.point - q).norm();
    return p;
}

std::vector<double> PathAlignment::evened(const std::vector<Hit>& hits,
                                          const geom::Polyline& chain) const {
    // Normal equations of sum w_i (s_i - hit_i)^2 + l_i^2 / step_i (s_i+1 - s_i - step_i)^2, which
    // are tridiagonal, by elimination.
    const std::size_t count = hits.size();
    std::vector<double> diagonal(count, 0.0), beside(count, 0.0), right(count, 0.0);
    for (std::size_t i = 0; i + 1 < count; ++i) {
        const double step = (chain[i + 1] - chain[i]).norm();
        if (!(step > 0.0)) continue;
        const double far = std::max(hits[i].point.distance, hits[i + 1].point.distance);
        const double stiffness = std::pow(elastic_length_rel * far, 2) / step;
        for (const std::size_t k : {i, i + 1}) {
            diagonal[k] += 0.5 * step + stiffness;
            right[k] += 0.5 * step * hits[k].arc + (k == i ? -1.0 : 1.0) * stiffness * step;
        }
        beside[i] = -stiffness;
    }
    for (std::size_t i = 1; i < count; ++i) {
        if (!(diagonal[i - 1] > 0.0)) continue;
        const double factor = beside[i - 1] / diagonal[i - 1];
        diagonal[i] -= factor * beside[i - 1];
        right[i] -= factor * right[i - 1];
    }
    std::vector<double> arcs(count);
    for (std::size_t i = count; i-- > 0;) {
        const double after = i + 1 < count ? beside[i] * arcs[i + 1] : 0.0;
        arcs[i] = diagonal[i] > 0.0 ? (right[i] - after) / diagonal[i] : hits[i].arc;
    }
    return arcs;
}

std::vector<FeaturePoint> PathAlignment::targets(const geom::Polyline& chain) const {
    const std::vector<std::size_t> segments = segments_of(chain);
    std::vector<Hit> hits;
    for (std::size_t i = 0; i < chain.size(); ++i) {
        const std::size_t j = segments[i];
        const double from = places_[j > 0 ? j - 1 : j].arc;
        const double to = places_[std::min(j + 2, places_.size() - 1)].arc;
        hits.push_back(nearest_between(from, to, chain[i]));
    }
    const std::vector<double> arcs = evened(hits, chain);
    std::vector<FeaturePoint> result;
    for (std::size_t i = 0; i < chain.size(); ++i) result.push_back(point_at(arcs[i], chain[i]));
    return result;
}

}  // namespace patchwright::fit
