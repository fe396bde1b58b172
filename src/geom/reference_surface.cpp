#include <patchwright/base/error.h>
#include <patchwright/geom/reference_surface.h>

namespace patchwright::geom {

std::vector<SurfaceSample> ReferenceSurface::sample(int) const { return {}; }

FootPoint ReferenceSurface::foot_point_on(const std::vector<char>&, const Vec3& query,
                                          const std::optional<Vec3>& side) const {
    return foot_point(query, side);
}

std::vector<FaceBorder> ReferenceSurface::face_borders() const { return {}; }

const Features& ReferenceSurface::features() const {
    static const Features none;
    return none;
}

FeaturePoint ReferenceSurface::nearest_on_curve(int, const Vec3&,
                                                const std::optional<ArcRange>&) const {
    throw base::InvalidArgument("nearest_on_curve: the reference has no feature curves");
}

FeaturePoint ReferenceSurface::point_on_curve(int, double) const {
    throw base::InvalidArgument("point_on_curve: the reference has no feature curves");
}

}  // namespace patchwright::geom
