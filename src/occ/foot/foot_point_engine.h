// Search for foot points over faces and their boundary edges.
#pragma once

#include "occ/foot/curve_search.h"
#include "occ/foot/face_surface.h"
#include "occ/foot/feature_curves.h"
#include "occ/foot/kernel_extrema.h"
#include "occ/foot/model_edges.h"
#include "occ/foot/reference_mesh.h"

#include <patchwright/geom/reference_surface.h>

#include <memory>
#include <memory_resource>
#include <vector>

namespace patchwright::occ {

/// Everything a search needs to know of the model.
struct SearchModel {
    /// All splines in one place: with many faces, what lies anywhere is paid for in each query.
    std::pmr::monotonic_buffer_resource memory{1u << 16};
    std::vector<FaceSurface> surfaces;
    ReferenceMesh mesh;
    EdgeNetwork network;
    CurveSearch all_edges, sharp_edges, free_edges, smooth_edges;
    FeatureCurves features;
    geom::Bvh corners;  ///< over features.features().corners
    geom::Box3 bounds;
    double size = 0.0;                            ///< diagonal of `bounds`
    double side_reach = 0.0;                      ///< millimetres
    std::unique_ptr<const KernelExtrema> kernel;  ///< in place of the search, where there is one
};

/// True nearest point of the trimmed model.
/// @param bound  something on the model is known to be no farther: saves time, changes nothing
geom::FootPoint nearest_point(const SearchModel& model, const geom::Vec3& query, double bound);

/// The same, preferring points that face `side` within the model's reach.
geom::FootPoint nearest_point_facing(const SearchModel& model, const geom::Vec3& query,
                                     const geom::Vec3& side, double bound);

/// Of some faces only, one flag a face; those that face `side` are preferred as above.
geom::FootPoint nearest_point_on(const SearchModel& model, const std::vector<char>& faces,
                                 const geom::Vec3& query, const std::optional<geom::Vec3>& side);

/// The same of the kernel's extrema.
/// @pre the model has them
geom::FootPoint nearest_point_by_kernel(const SearchModel& model, const geom::Vec3& query);
geom::FootPoint nearest_point_facing_by_kernel(const SearchModel& model, const geom::Vec3& query,
                                               const geom::Vec3& side);

}  // namespace patchwright::occ
