#include "geom/mesh_curves.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace patchwright::geom {

MeshCurves::MeshCurves(const TriangleMesh& mesh, const MeshFeatures& features)
    : features_(&features) {
    for (std::size_t c = 0; c < features.chains.size(); ++c) {
        const MeshChain& chain = features.chains[c];
        std::vector<Segment> segments;
        for (std::size_t i = 0; i + 1 < chain.points.size(); ++i)
            segments.push_back({int(c), mesh.points.row(chain.points[i]),
                                mesh.points.row(chain.points[i + 1]), chain.arc[i],
                                chain.arc[i + 1]});
        trees_.push_back(tree_of(segments));
        auto& of_kind = features.features.curves[c].kind == FeatureKind::Free ? free_ : sharp_;
        of_kind.insert(of_kind.end(), segments.begin(), segments.end());
        segments_.push_back(std::move(segments));
    }
    sharp_tree_ = tree_of(sharp_);
    free_tree_ = tree_of(free_);
    std::vector<Box3> boxes;
    for (const FeatureCorner& corner : features.features.corners) {
        boxes.emplace_back();
        boxes.back().add(corner.point);
    }
    corner_tree_ = Bvh(boxes);
}

Bvh MeshCurves::tree_of(const std::vector<Segment>& segments) {
    std::vector<Box3> boxes(segments.size());
    for (std::size_t i = 0; i < segments.size(); ++i) {
        boxes[i].add(segments[i].from);
        boxes[i].add(segments[i].to);
    }
    return Bvh(boxes);
}

FeaturePoint MeshCurves::nearest_on(const Segment& segment, const Vec3& query, double from,
                                    double to) {
    const Vec3 along = segment.to - segment.from;
    const double length = segment.end - segment.start;
    const Vec3 tangent = length > 0.0 ? Vec3(along / length) : Vec3::Zero();
    const double arc = std::clamp(segment.start + (query - segment.from).dot(tangent), from, to);
    FeaturePoint result;
    result.point = segment.from + (arc - segment.start) * tangent;
    result.distance = (query - result.point).norm();
    result.feature = segment.curve;
    result.arc_length = arc;
    result.tangent = tangent;
    return result;
}

std::optional<FeaturePoint> MeshCurves::search(const Bvh& tree,
                                               const std::vector<Segment>& segments,
                                               const Vec3& query) {
    std::optional<FeaturePoint> best;
    tree.nearest(query, std::numeric_limits<double>::infinity(), [&](int item, double bound) {
        const Segment& s = segments[std::size_t(item)];
        const FeaturePoint found = nearest_on(s, query, s.start, s.end);
        if (best && found.distance >= best->distance) return bound;
        best = found;
        return found.distance;
    });
    return best;
}

FeaturePoint MeshCurves::nearest(int curve, const Vec3& query,
                                 const std::optional<ArcRange>& within) const {
    const auto& segments = segments_[std::size_t(curve)];
    if (!within) return *search(trees_[std::size_t(curve)], segments, query);
    // A range on a closed curve may run across its start.
    const FeatureCurve& c = features_->features.curves[std::size_t(curve)];
    std::optional<FeaturePoint> best;
    const int rounds = c.closed ? int(std::floor(within->from / c.length)) : 0;
    const int last = c.closed ? int(std::floor(within->to / c.length)) : 0;
    for (int round = rounds; round <= last; ++round) {
        const double low = std::clamp(within->from - round * c.length, 0.0, c.length);
        const double high = std::clamp(within->to - round * c.length, 0.0, c.length);
        for (const Segment& s : segments) {
            if (s.end < low || s.start > high) continue;
            const FeaturePoint found =
                nearest_on(s, query, std::max(low, s.start), std::min(high, s.end));
            if (!best || found.distance < best->distance) best = found;
        }
    }
    return best ? *best : at(curve, within->from);
}

FeaturePoint MeshCurves::at(int curve, double arc_length) const {
    const auto& segments = segments_[std::size_t(curve)];
    const FeatureCurve& c = features_->features.curves[std::size_t(curve)];
    double arc = arc_length;
    if (c.closed) arc -= c.length * std::floor(arc / c.length);
    arc = std::clamp(arc, 0.0, c.length);
    auto found = std::lower_bound(segments.begin(), segments.end(), arc,
                                  [](const Segment& s, double a) { return s.end < a; });
    if (found == segments.end()) --found;
    FeaturePoint result = nearest_on(*found, found->from, arc, arc);
    result.distance = 0.0;
    return result;
}

std::optional<FeaturePoint> MeshCurves::nearest(const Vec3& query, FeatureKind kind) const {
    if (kind == FeatureKind::Sharp) return search(sharp_tree_, sharp_, query);
    if (kind == FeatureKind::Free) return search(free_tree_, free_, query);
    std::optional<FeaturePoint> best;
    if (kind == FeatureKind::Smooth) return best;
    corner_tree_.nearest(
        query, std::numeric_limits<double>::infinity(), [&](int item, double bound) {
            const Vec3& point = features_->features.corners[std::size_t(item)].point;
            const double distance = (point - query).norm();
            if (best && distance >= best->distance) return bound;
            best = FeaturePoint{point, distance, item};
            return distance;
        });
    return best;
}

}  // namespace patchwright::geom
