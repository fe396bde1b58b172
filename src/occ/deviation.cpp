#include "deviation_bound.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/occ/deviation.h>

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace patchwright::occ {

namespace {

// Of the diagonal.
constexpr double places_apart = 0.05, bound_slack = 1e-5;

void require_samples(int samples) {
    if (samples < 1) {
        throw base::InvalidArgument(fmt::format("{} samples: at least one is needed", samples));
    }
}

}  // namespace

fit::Deviation measure_deviation(const CadReference& from, const CadReference& to,
                                 const DeviationMeasure& options) {
    require_samples(options.samples);
    const std::vector<CadReference::Sample> points = from.sample(options.samples);
    std::vector<fit::DistanceSample> distances(points.size());
    // In blocks, as progress is reported from the calling thread only.
    constexpr std::size_t block = 8192, grain = 128;
    for (std::size_t start = 0; start < points.size(); start += block) {
        base::report_progress(options.progress, "deviation", double(start) / double(points.size()));
        const std::size_t count = std::min(block, points.size() - start);
        base::parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = start + begin; i < start + end; ++i) {
                distances[i] = {points[i].point, points[i].face,
                                to.foot_point(points[i].point).distance, points[i].weight};
            }
        });
    }
    base::report_progress(options.progress, "deviation", 1.0);
    const double diagonal = from.bounds().diagonal();
    fit::Deviation result =
        fit::deviation_statistics(distances, {.apart_mm = places_apart * diagonal});
    if (options.with_bound) {
        result.bound = deviation_bound(from, to,
                                       {.at_least = result.max,
                                        .slack_mm = bound_slack * diagonal,
                                        .progress = options.progress});
    }
    return result;
}

std::optional<fit::Deviation> measure_feature_deviation(const CadReference& from,
                                                        const CadReference& to,
                                                        geom::FeatureKind kind, int samples) {
    require_samples(samples);
    double length = 0.0;
    for (const geom::FeatureCurve& curve : from.features().curves)
        length += curve.kind == kind ? curve.length : 0.0;
    if (!(length > 0.0)) return std::nullopt;
    std::vector<fit::DistanceSample> distances;
    for (const auto& sample : from.sample_curves(kind, length / samples)) {
        const auto nearest = to.feature_point(sample.point, kind);
        if (!nearest) return std::nullopt;
        distances.push_back({sample.point, sample.curve, nearest->distance, sample.weight});
    }
    return fit::deviation_statistics(distances,
                                     {.apart_mm = places_apart * from.bounds().diagonal()});
}

}  // namespace patchwright::occ
