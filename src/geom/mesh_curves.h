// Nearest points on the feature curves of a triangle mesh.
#pragma once

#include "geom/bvh.h"
#include "geom/mesh_features.h"

#include <vector>

namespace patchwright::geom {

class MeshCurves {
  public:
    MeshCurves() = default;
    /// @pre  both outlive the curves
    MeshCurves(const TriangleMesh& mesh, const MeshFeatures& features);

    [[nodiscard]] FeaturePoint nearest(int curve, const Vec3& query,
                                       const std::optional<ArcRange>& within) const;
    [[nodiscard]] FeaturePoint at(int curve, double arc_length) const;
    [[nodiscard]] std::optional<FeaturePoint> nearest(const Vec3& query, FeatureKind kind) const;

  private:
    struct Segment {
        int curve;
        Vec3 from, to;
        double start, end;  ///< arc lengths
    };
    [[nodiscard]] static Bvh tree_of(const std::vector<Segment>& segments);
    /// Nearest point between two arc lengths of the segment.
    [[nodiscard]] static FeaturePoint nearest_on(const Segment& segment, const Vec3& query,
                                                 double from, double to);
    [[nodiscard]] static std::optional<FeaturePoint> search(const Bvh& tree,
                                                            const std::vector<Segment>& segments,
                                                            const Vec3& query);

    const MeshFeatures* features_ = nullptr;
    std::vector<std::vector<Segment>> segments_;  ///< by curve
    std::vector<Bvh> trees_;
    std::vector<Segment> sharp_, free_;
    Bvh sharp_tree_, free_tree_, corner_tree_;
};

}  // namespace patchwright::geom
