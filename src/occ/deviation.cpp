#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/occ/deviation.h>

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace patchwright::occ {

fit::Deviation measure_deviation(const CadReference& from, const CadReference& to, int samples,
                                 const base::Progress& progress) {
    if (samples < 1) {
        throw base::InvalidArgument(fmt::format("{} samples: at least one is needed", samples));
    }
    const std::vector<CadReference::Sample> points = from.sample(samples);
    std::vector<fit::DistanceSample> distances(points.size());
    // In blocks, as progress is reported from the calling thread only.
    constexpr std::size_t block = 8192, grain = 128;
    for (std::size_t start = 0; start < points.size(); start += block) {
        base::report_progress(progress, "deviation", double(start) / double(points.size()));
        const std::size_t count = std::min(block, points.size() - start);
        base::parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = start + begin; i < start + end; ++i) {
                distances[i] = {points[i].point, points[i].face,
                                to.foot_point(points[i].point).distance};
            }
        });
    }
    base::report_progress(progress, "deviation", 1.0);
    return fit::deviation_statistics(distances);
}

}  // namespace patchwright::occ
