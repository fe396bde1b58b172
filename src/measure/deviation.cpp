#include "measure/crease_distance.h"
#include "measure/progress_loop.h"

#include <patchwright/base/error.h>
#include <patchwright/measure/deviation.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace patchwright::measure {

namespace {

/// Entries of Deviation::worst are at least this far from each other, of the diagonal: so far that
/// they are seen as different places of the model.
constexpr double places_apart = 0.05;

/// Of a sharp curve: 64 pieces, short against the curves that are looked at one by one.
constexpr int samples_of_curve = 65;
/// About a degree: what readers and users take for smooth.
constexpr double least_kink_rad = 0.02;

void require_samples(int samples) {
    if (samples < 1) {
        throw base::InvalidArgument(fmt::format("{} samples: at least one is needed", samples));
    }
}

}  // namespace

std::optional<double> tangent_plane_angle(const geom::Vec3& a, const geom::Vec3& b) {
    if (a.isZero(0.0) || b.isZero(0.0)) return std::nullopt;
    return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

Deviation measure_deviation(const geom::ModelSurface& from, const geom::ModelSurface& to,
                            const DeviationMeasure& options) {
    require_samples(options.samples);
    const std::vector<geom::SurfaceSample> points = from.sample(options.samples);
    std::vector<DistanceSample> distances(points.size());
    loop_with_progress(
        0, points.size(), 8192, 128, "deviation", options.progress, [&](std::size_t i) {
            const geom::FootPoint foot = to.foot_point(points[i].point);
            distances[i] = {points[i].point, points[i].face, foot.distance, points[i].weight,
                            tangent_plane_angle(points[i].normal, foot.normal)};
        });
    base::report_progress(options.progress, "deviation", 1.0);
    const double diagonal = from.bounds().diagonal();
    Deviation result =
        deviation_statistics(distances, {.apart_mm = places_apart * diagonal, .of_faces = true});
    if (options.with_bound)
        result.bound =
            measure_bound(from, to, {.found_mm = result.max, .progress = options.progress});
    return result;
}

double largest_deviation(const geom::BsplineSurface& surface,
                         const geom::ReferenceSurface& reference, int samples) {
    require_samples(samples);
    const auto middle = [&](const std::vector<double>& knots, int i) {
        return knots.back() * (i + 0.5) / samples;
    };
    double largest = 0.0;
    for (int i = 0; i < samples; ++i) {
        for (int j = 0; j < samples; ++j) {
            const auto at = surface.at(middle(surface.knots_u, i), middle(surface.knots_v, j));
            largest = std::max(largest, reference.foot_point(at.position).distance);
        }
    }
    return largest;
}

std::optional<Deviation> measure_feature_deviation(const geom::ModelSurface& from,
                                                   const geom::ModelSurface& to,
                                                   geom::FeatureKind kind,
                                                   const FeatureMeasure& options) {
    require_samples(options.samples);
    double length = 0.0;
    for (const geom::FeatureCurve& curve : from.features().curves)
        length += curve.kind == kind ? curve.length : 0.0;
    if (!(length > 0.0)) return std::nullopt;
    std::vector<DistanceSample> distances;
    const std::vector<geom::CurveSample> points =
        from.sample_curves(kind, length / options.samples);
    for (const auto& sample : points) {
        constexpr std::size_t block = 256;
        if (distances.size() % block == 0)
            base::report_progress(options.progress, "sharp curves",
                                  double(distances.size()) / double(points.size()));
        const auto nearest = to.feature_point(sample.point, kind);
        if (!nearest) return std::nullopt;
        distances.push_back({sample.point, sample.curve, nearest->distance, sample.weight});
    }
    return deviation_statistics(distances, {.apart_mm = places_apart * from.bounds().diagonal()});
}

std::vector<SharpCurveDistance> measure_sharp_curves(const geom::ModelSurface& from,
                                                     const geom::ModelSurface& to,
                                                     double longer_than_mm,
                                                     const base::Progress& progress) {
    using geom::FeatureKind;
    const std::vector<int> kinked = kinked_curves(to, least_kink_rad);
    const auto distance = [&](const geom::Vec3& p, bool any_edge) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const FeatureKind kind : {FeatureKind::Sharp, FeatureKind::Free})
            if (const auto edge = to.feature_point(p, kind))
                nearest = std::min(nearest, edge->distance);
        for (const int curve : kinked)
            nearest = std::min(nearest, to.nearest_on_curve(curve, p).distance);
        if (!any_edge) return nearest;
        const auto smooth = to.feature_point(p, FeatureKind::Smooth);
        return smooth ? std::min(nearest, smooth->distance) : nearest;
    };
    const auto& curves = from.features().curves;
    std::vector<SharpCurveDistance> result;
    for (std::size_t i = 0; i < curves.size(); ++i) {
        const geom::FeatureCurve& curve = curves[i];
        if (curve.kind != FeatureKind::Sharp || !(curve.length > longer_than_mm)) continue;
        const bool fades = curve.least_angle_rad < geom::default_sharp_angle_rad;
        base::report_progress(progress, "sharp curves", double(i) / double(curves.size()));
        SharpCurveDistance found{.curve = int(i), .length = curve.length};
        for (int k = 0; k < samples_of_curve; ++k) {
            const geom::Vec3 p =
                from.point_on_curve(int(i), curve.length * k / (samples_of_curve - 1)).point;
            const double nearest = distance(p, fades);
            if (nearest < found.distance) continue;
            found.distance = nearest;
            found.at = p;
        }
        result.push_back(found);
    }
    return result;
}

}  // namespace patchwright::measure
