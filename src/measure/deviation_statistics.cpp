#include <patchwright/measure/deviation_statistics.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace patchwright::measure {

namespace {

std::vector<DeviationPlace> worst_places(const std::vector<DistanceSample>& samples,
                                         const std::vector<std::size_t>& ascending,
                                         const DeviationOptions& options) {
    std::vector<DeviationPlace> places;
    for (auto it = ascending.rbegin(); it != ascending.rend(); ++it) {
        if (static_cast<int>(places.size()) >= std::max(options.places, 1)) break;
        const DistanceSample& sample = samples[*it];
        const bool near = std::any_of(places.begin(), places.end(), [&](const auto& place) {
            return (place.point - sample.point).norm() < options.apart_mm;
        });
        if (!near) places.push_back({sample.point, sample.face, sample.distance});
    }
    return places;
}

}  // namespace

Deviation deviation_statistics(const std::vector<DistanceSample>& samples,
                               const DeviationOptions& options) {
    Deviation result;
    result.samples = static_cast<int>(samples.size());
    if (samples.empty()) return result;
    std::vector<std::size_t> ascending(samples.size());
    std::iota(ascending.begin(), ascending.end(), std::size_t(0));
    std::stable_sort(ascending.begin(), ascending.end(), [&](std::size_t a, std::size_t b) {
        return samples[a].distance < samples[b].distance;
    });
    result.worst = worst_places(samples, ascending, options);
    result.max = result.worst.front().distance;
    result.at = result.worst.front().point;
    result.face = result.worst.front().face;

    double sum_of_squares = 0.0, weight = 0.0;
    for (const DistanceSample& sample : samples) {
        weight += sample.weight;
        sum_of_squares += sample.weight * sample.distance * sample.distance;
    }
    const auto percentile = [&](double share) {
        // Rounding must not push a share that is met exactly to the next sample.
        const double wanted = share * weight * (1.0 - 1e-12);
        double passed = 0.0;
        for (const std::size_t i : ascending) {
            passed += samples[i].weight;
            if (passed >= wanted) return samples[i].distance;
        }
        return result.max;
    };
    if (!(weight > 0.0)) return result;
    result.rms = std::sqrt(sum_of_squares / weight);
    result.p50 = percentile(0.50);
    result.p95 = percentile(0.95);
    result.p99 = percentile(0.99);
    return result;
}

}  // namespace patchwright::measure
