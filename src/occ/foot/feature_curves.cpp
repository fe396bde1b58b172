#include "occ/foot/feature_curves.h"

#include "geom/angle.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

namespace patchwright::occ {

using geom::FeatureCurve;
using geom::FeatureKind;
using geom::FeaturePoint;
using geom::Vec3;

namespace {

FeatureKind feature_kind(EdgeKind kind) {
    switch (kind) {
        case EdgeKind::Sharp: return FeatureKind::Sharp;
        case EdgeKind::Free: return FeatureKind::Free;
        case EdgeKind::Smooth: break;
    }
    return FeatureKind::Smooth;
}

}  // namespace

/// Walks from edge to edge through vertices where exactly two of a kind meet and go straight on.
class FeatureCurves::Chaining {
  public:
    struct Step {
        int edge;
        bool reversed;
    };

    explicit Chaining(const EdgeNetwork& network)
        : network_(network),
          ends_(network.vertices.size()),
          corner_(network.vertices.size(), false) {
        for (std::size_t i = 0; i < network.edges.size(); ++i) {
            const ModelEdge& edge = network.edges[i];
            if (edge.start >= 0) ends_[std::size_t(edge.start)].push_back({int(i), false});
            if (edge.end >= 0) ends_[std::size_t(edge.end)].push_back({int(i), true});
        }
        for (const NetworkCorner& corner : network.corners)
            corner_[std::size_t(corner.vertex)] = true;
    }

    std::deque<Step> chain_from(int seed) const {
        std::deque<Step> chain{{seed, false}};
        while (const auto next = after(chain.back())) {
            if (next->edge == seed) return chain;
            chain.push_back(*next);
        }
        while (const auto before = after({chain.front().edge, !chain.front().reversed}))
            chain.push_front({before->edge, !before->reversed});
        return chain;
    }

  private:
    struct DirectedEnd {
        int edge;
        bool at_end;
    };

    [[nodiscard]] Vec3 outward(const DirectedEnd& end) const {
        const ModelEdge& edge = network_.edges[std::size_t(end.edge)];
        return end.at_end ? Vec3(-edge.tangent(edge.last)) : edge.tangent(edge.first);
    }

    [[nodiscard]] std::optional<Step> after(const Step& step) const {
        const ModelEdge& edge = network_.edges[std::size_t(step.edge)];
        const int vertex = step.reversed ? edge.start : edge.end;
        if (vertex < 0 || corner_[std::size_t(vertex)]) return std::nullopt;
        const DirectedEnd here{step.edge, !step.reversed};
        const DirectedEnd* other = nullptr;
        for (const DirectedEnd& end : ends_[std::size_t(vertex)]) {
            if (end.edge == here.edge && end.at_end == here.at_end) continue;
            const EdgeKind kind = network_.edges[std::size_t(end.edge)].kind;
            if (kind != edge.kind) {
                // Features cut smooth curves, not the other way round.
                if (edge.kind == EdgeKind::Smooth) return std::nullopt;
                continue;
            }
            if (other != nullptr) return std::nullopt;
            other = &end;
        }
        if (other == nullptr) return std::nullopt;
        // Ends of features that turn are corners already.
        if (edge.kind == EdgeKind::Smooth &&
            geom::angle_between(outward(here), -outward(*other)) > network_.sharp_angle_rad)
            return std::nullopt;
        return Step{other->edge, other->at_end};
    }

    const EdgeNetwork& network_;
    std::vector<std::vector<DirectedEnd>> ends_;
    std::vector<bool> corner_;
};

FeatureCurves::FeatureCurves(const EdgeNetwork& network, double deflection, double size)
    : network_(&network), places_(network.edges.size()) {
    arcs_.reserve(network.edges.size());
    for (const ModelEdge& edge : network.edges) arcs_.emplace_back(edge);
    const Chaining chaining(network);
    for (const EdgeKind kind : {EdgeKind::Sharp, EdgeKind::Free, EdgeKind::Smooth}) {
        for (std::size_t seed = 0; seed < network.edges.size(); ++seed) {
            if (network.edges[seed].kind != kind || places_[seed].curve >= 0) continue;
            EdgeChain chain;
            std::vector<int> edges;
            for (const auto& [edge, reversed] : chaining.chain_from(int(seed))) {
                places_[std::size_t(edge)] = {int(chains_.size()), int(chain.pieces.size())};
                chain.pieces.push_back({edge, reversed, 0.0});
                edges.push_back(edge);
            }
            chain.search = CurveSearch(network.edges, edges, deflection, size);
            chains_.push_back(std::move(chain));
            measure(chains_.size() - 1);
        }
    }
    index_corners();
}

void FeatureCurves::measure(std::size_t number) {
    EdgeChain& chain = chains_[number];
    const auto edge_of = [&](const EdgePiece& piece) -> const ModelEdge& {
        return network_->edges[std::size_t(piece.edge)];
    };
    FeatureCurve curve;
    curve.kind = feature_kind(edge_of(chain.pieces.front()).kind);
    curve.least_angle_rad = std::numeric_limits<double>::infinity();
    for (EdgePiece& piece : chain.pieces) {
        piece.start = curve.length;
        curve.length += arcs_[std::size_t(piece.edge)].length();
        curve.least_angle_rad = std::min(curve.least_angle_rad, edge_of(piece).least_angle);
        curve.greatest_angle_rad =
            std::max(curve.greatest_angle_rad, edge_of(piece).greatest_angle);
    }
    const EdgePiece &first = chain.pieces.front(), &last = chain.pieces.back();
    const int from = first.reversed ? edge_of(first).end : edge_of(first).start;
    const int to = last.reversed ? edge_of(last).start : edge_of(last).end;
    curve.closed = from >= 0 && from == to;
    features_.curves.push_back(curve);
    const int at_start = int(number);
    features_.curves.back().start = at(at_start, 0.0).point;
    // Round and round leads a closed curve's end back to its start.
    features_.curves.back().end =
        curve.closed ? features_.curves.back().start : at(at_start, curve.length).point;
}

void FeatureCurves::index_corners() {
    std::vector<int> number(network_->vertices.size(), -1);
    for (const NetworkCorner& corner : network_->corners) {
        number[std::size_t(corner.vertex)] = int(features_.corners.size());
        features_.corners.push_back(
            {network_->vertices[std::size_t(corner.vertex)], corner.kind, {}});
    }
    const auto corner_at = [&](int vertex) {
        return vertex < 0 ? -1 : number[std::size_t(vertex)];
    };
    for (std::size_t i = 0; i < chains_.size(); ++i) {
        FeatureCurve& curve = features_.curves[i];
        const EdgePiece &first = chains_[i].pieces.front(), &last = chains_[i].pieces.back();
        const ModelEdge& a = network_->edges[std::size_t(first.edge)];
        const ModelEdge& b = network_->edges[std::size_t(last.edge)];
        curve.start_corner = corner_at(first.reversed ? a.end : a.start);
        curve.end_corner = corner_at(last.reversed ? b.start : b.end);
        if (curve.kind == FeatureKind::Smooth) continue;
        for (const int corner : {curve.start_corner, curve.end_corner})
            if (corner >= 0) features_.corners[std::size_t(corner)].curves.push_back(int(i));
    }
}

FeaturePoint FeatureCurves::point_of(const CurveHit& hit) const {
    const CurvePlace& place = places_[std::size_t(hit.edge)];
    const EdgePiece& piece = chains_[std::size_t(place.curve)].pieces[std::size_t(place.piece)];
    const ArcLength& arc = arcs_[std::size_t(hit.edge)];
    const double along = arc.at(hit.t);
    const Vec3 tangent = network_->edges[std::size_t(hit.edge)].tangent(hit.t);
    return {hit.point, hit.distance, place.curve,
            piece.start + (piece.reversed ? arc.length() - along : along),
            piece.reversed ? Vec3(-tangent) : tangent};
}

FeaturePoint FeatureCurves::at(int number, double arc_length) const {
    const EdgeChain& chain = chains_[std::size_t(number)];
    const FeatureCurve& curve = features_.curves[std::size_t(number)];
    double s = std::clamp(arc_length, 0.0, curve.length);
    if (curve.closed && s != arc_length)
        s = arc_length - std::floor(arc_length / curve.length) * curve.length;
    const auto next =
        std::upper_bound(chain.pieces.begin() + 1, chain.pieces.end(), s,
                         [](double a, const EdgePiece& piece) { return a < piece.start; });
    const EdgePiece& piece = *(next - 1);
    const ModelEdge& edge = network_->edges[std::size_t(piece.edge)];
    const ArcLength& arc = arcs_[std::size_t(piece.edge)];
    const double along = s - piece.start;
    const double t = arc.parameter(piece.reversed ? arc.length() - along : along);
    const Vec3 tangent = edge.tangent(t);
    return {edge.at(t), 0.0, number, s, piece.reversed ? Vec3(-tangent) : tangent};
}

// The parts of an edge that a piece of its curve covers: two where a closed curve's piece ends on
// the edge that it starts on.
std::vector<std::array<double, 2>> FeatureCurves::parameters_within(
    const EdgeChain& chain, const FeatureCurve& curve, int number,
    const geom::ArcRange& within) const {
    const EdgePiece& piece = chain.pieces[std::size_t(places_[std::size_t(number)].piece)];
    const ArcLength& arc = arcs_[std::size_t(number)];
    std::vector<std::array<double, 2>> result;
    const double turns = curve.closed ? std::floor(within.from / curve.length) : 0.0;
    for (const double shift : {turns * curve.length, (turns + 1.0) * curve.length}) {
        double from = std::max(within.from - shift - piece.start, 0.0);
        double to = std::min(within.to - shift - piece.start, arc.length());
        if (from <= to) {
            if (piece.reversed) {
                std::swap(from, to);
                from = arc.length() - from;
                to = arc.length() - to;
            }
            result.push_back({arc.parameter(from), arc.parameter(to)});
        }
        if (!curve.closed) break;
    }
    return result;
}

FeaturePoint FeatureCurves::nearest(int number, const Vec3& query,
                                    const std::optional<geom::ArcRange>& within) const {
    const EdgeChain& chain = chains_[std::size_t(number)];
    const FeatureCurve& curve = features_.curves[std::size_t(number)];
    constexpr double infinity = std::numeric_limits<double>::infinity();
    CurveHit best;
    best.distance = infinity;
    const auto visit = [&](const CurveHit& hit, double bound) {
        if (hit.distance >= best.distance) return bound;
        best = hit;
        return hit.distance;
    };
    if (!within || (curve.closed && within->to - within->from >= curve.length)) {
        chain.search.visit(query, infinity, visit);
        return point_of(best);
    }
    // Beyond both ends of an open curve there is its end.
    geom::ArcRange range = *within;
    if (!curve.closed) {
        range.from = std::clamp(range.from, 0.0, curve.length);
        range.to = std::clamp(range.to, 0.0, curve.length);
    }
    std::vector<std::vector<std::array<double, 2>>> parts;
    for (const EdgePiece& piece : chain.pieces)
        parts.push_back(parameters_within(chain, curve, piece.edge, range));
    chain.search.visit_within(
        query, infinity,
        [&](int edge) -> const auto& {
            return parts[std::size_t(places_[std::size_t(edge)].piece)];
        },
        visit);
    // A piece shorter than rounding lies between two edges.
    if (best.edge < 0) {
        FeaturePoint end = at(number, range.from);
        end.distance = (end.point - query).norm();
        return end;
    }
    return point_of(best);
}

std::vector<geom::FaceBorder> FeatureCurves::face_borders() const {
    std::vector<geom::FaceBorder> result;
    for (std::size_t e = 0; e < network_->edges.size(); ++e) {
        const std::vector<FaceOfEdge>& uses = network_->edges[e].uses;
        if (uses.empty() || uses.size() > 2) continue;
        const CurvePlace& place = places_[e];
        const bool against =
            chains_[std::size_t(place.curve)].pieces[std::size_t(place.piece)].reversed;
        geom::FaceBorder border{.curve = place.curve};
        // A face's boundary has the face on its left.
        (uses[0].reversed == against ? border.left : border.right) = uses[0].face;
        if (uses.size() == 2) {
            // Faces of opposite orientation run along the edge in the same direction.
            int& other = uses[0].reversed == against ? border.right : border.left;
            other = uses[1].face;
        }
        result.push_back(border);
    }
    return result;
}

}  // namespace patchwright::occ
