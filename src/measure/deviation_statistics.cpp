#include <patchwright/measure/deviation_statistics.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

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

/// A mean square of the weighted values that were added; of the plain ones while no weight is.
class MeanSquare {
  public:
    void add(double value, double weight) {
        weighted_ += weight * value * value;
        weight_ += weight;
        plain_ += value * value;
        ++count_;
        largest_ = std::max(largest_, value);
    }
    [[nodiscard]] int count() const { return count_; }
    [[nodiscard]] double largest() const { return largest_; }
    [[nodiscard]] double root() const {
        return std::sqrt(weight_ > 0.0 ? weighted_ / weight_ : plain_ / std::max(count_, 1));
    }

  private:
    double weighted_ = 0.0, weight_ = 0.0, plain_ = 0.0, largest_ = 0.0;
    int count_ = 0;
};

std::vector<DeviationOfFace> deviation_of_faces(const std::vector<DistanceSample>& samples) {
    std::map<int, std::pair<MeanSquare, MeanSquare>> of_face;  // distances, angles
    for (const DistanceSample& sample : samples) {
        auto& [distances, angles] = of_face[sample.face];
        distances.add(sample.distance, sample.weight);
        if (sample.normal_angle_rad) angles.add(*sample.normal_angle_rad, sample.weight);
    }
    std::vector<DeviationOfFace> faces;
    for (const auto& [face, figures] : of_face) {
        const auto& [distances, angles] = figures;
        faces.push_back({.face = face,
                         .samples = distances.count(),
                         .max = distances.largest(),
                         .rms = distances.root()});
        if (angles.count() == 0) continue;
        faces.back().normal_max_rad = angles.largest();
        faces.back().normal_rms_rad = angles.root();
    }
    return faces;
}

Histogram histogram_of(const std::vector<DistanceSample>& samples, double max, double weight,
                       int bins) {
    Histogram result{.width = max / bins, .shares = std::vector<double>(std::size_t(bins), 0.0)};
    for (const DistanceSample& sample : samples) {
        const double place = result.width > 0.0 ? sample.distance / result.width : 0.0;
        result.shares[std::size_t(std::min(int(place), bins - 1))] += sample.weight / weight;
    }
    return result;
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
    if (options.of_faces) result.faces = deviation_of_faces(samples);
    if (!(weight > 0.0)) return result;
    if (options.of_faces)
        result.histogram = histogram_of(samples, result.max, weight, options.histogram_bins);
    result.rms = std::sqrt(sum_of_squares / weight);
    result.p50 = percentile(0.50);
    result.p95 = percentile(0.95);
    result.p99 = percentile(0.99);
    return result;
}

}  // namespace patchwright::measure
