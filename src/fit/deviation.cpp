#include <patchwright/fit/deviation.h>

#include <algorithm>
#include <cmath>

namespace patchwright::fit {

Deviation deviation_statistics(const std::vector<DistanceSample>& samples) {
    Deviation result;
    result.samples = static_cast<int>(samples.size());
    if (samples.empty()) return result;
    const auto worst = std::max_element(
        samples.begin(), samples.end(),
        [](const DistanceSample& a, const DistanceSample& b) { return a.distance < b.distance; });
    result.max = worst->distance;
    result.at = worst->point;
    result.face = worst->face;

    std::vector<double> sorted;
    sorted.reserve(samples.size());
    double sum_of_squares = 0.0;
    for (const DistanceSample& sample : samples) {
        sorted.push_back(sample.distance);
        sum_of_squares += sample.distance * sample.distance;
    }
    std::sort(sorted.begin(), sorted.end());
    const auto percentile = [&](double share) {
        const auto rank = static_cast<std::size_t>(std::ceil(share * double(sorted.size())));
        return sorted[std::max<std::size_t>(rank, 1) - 1];
    };
    result.rms = std::sqrt(sum_of_squares / double(samples.size()));
    result.p95 = percentile(0.95);
    result.p99 = percentile(0.99);
    return result;
}

}  // namespace patchwright::fit
