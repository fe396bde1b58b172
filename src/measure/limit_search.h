// Where a limit surface is nearest to given points.
#pragma once

#include "geom/bvh.h"

#include <patchwright/base/progress.h>
#include <patchwright/mesh/cage.h>
#include <patchwright/subd/limit_operator.h>

#include <vector>

namespace patchwright::measure {

/// A limit point near a query; lengths in the cage's unit.
struct NearLimit {
    int site = 0;  ///< number among face_sites()
    double u = 0.0, v = 0.0;
    geom::Vec3 point = geom::Vec3::Zero();
    geom::Vec3 normal = geom::Vec3::Zero();  ///< unit, or zero where there is none
    double distance = 0.0;
};

/// Whether a normal is within 73 degrees of a direction, both of any length. The edge of a
/// thin part, at right angles to both its sides, faces as neither does.
bool faces_alike(const geom::Vec3& normal, const geom::Vec3& direction);

/// Finds near limit points of one topology at any control points.
class LimitSearch {
  public:
    explicit LimitSearch(std::shared_ptr<const mesh::Topology> topology);

    /// For each query a limit point of the face whose facets are nearest, brought nearer by
    /// Gauss-Newton steps: so its distance is never less than the limit surface's.
    /// @param control_points  one row a vertex of the topology
    /// @param facing  empty, or a direction for each query: then only facets count that face alike,
    ///                and a query without such facets is infinitely far
    /// @throw Cancelled when the progress callback asks for it
    [[nodiscard]] std::vector<NearLimit> nearest(const geom::Points& control_points,
                                                 const std::vector<geom::Vec3>& queries,
                                                 const std::vector<geom::Vec3>& facing = {},
                                                 const base::Progress& progress = {}) const;

  private:
    [[nodiscard]] NearLimit improved(const geom::Points& control_points, NearLimit start,
                                     const geom::Vec3& query) const;

    std::vector<subd::Site> sites_;
    subd::LimitOperator grid_;
    subd::LimitEvaluator evaluator_;
};

}  // namespace patchwright::measure
