// The spans of one parameter of a spline surface.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory_resource>
#include <vector>

namespace patchwright::occ {

/// Where a parameter lies among the spans.
struct SpanPlace {
    int span;
    double x;      ///< -1 to 1 within the span
    double scale;  ///< dx / dt
};

/// The breaks of one parameter, and where a parameter lies among them.
class SplineAxis {
  public:
    using Values = std::pmr::vector<double>;
    SplineAxis(const std::vector<double>& breaks, bool periodic)
        : breaks_(breaks.begin(), breaks.end()),
          period_(periodic ? breaks_.back() - breaks_.front() : 0.0),
          buckets_per_unit_(0.0) {
        // A coarse map from the parameter to the span, for surfaces of many spans.
        const std::size_t count = 2 * breaks_.size();
        buckets_per_unit_ = double(count) / (breaks_.back() - breaks_.front());
        for (std::size_t i = 0; i + 1 < breaks_.size(); ++i)
            scale_.push_back(2.0 / (breaks_[i + 1] - breaks_[i]));
        first_break_ = breaks_.front();
        first_scale_ = scale_.front();
        std::size_t span = 0;
        for (std::size_t b = 0; b < count; ++b) {
            const double t = breaks_.front() + double(b) / buckets_per_unit_;
            while (span + 2 < breaks_.size() && breaks_[span + 1] <= t) ++span;
            first_.push_back(int(span));
        }
    }
    SplineAxis(const SplineAxis& other, std::pmr::memory_resource* memory)
        : breaks_(other.breaks_, memory),
          scale_(other.scale_, memory),
          period_(other.period_),
          buckets_per_unit_(other.buckets_per_unit_),
          first_break_(other.first_break_),
          first_scale_(other.first_scale_),
          first_(other.first_, memory) {}
    [[nodiscard]] int spans() const { return int(breaks_.size()) - 1; }

    /// A single span.
    struct SingleSpan {
        double first, scale;
        [[nodiscard, gnu::always_inline]] SpanPlace find(double t) const {
            return {0, (t - first) * scale - 1.0, scale};
        }
    };
    [[nodiscard]] SingleSpan line() const { return {first_break_, first_scale_}; }
    [[nodiscard]] bool is_line() const { return scale_.size() == 1 && !(period_ > 0.0); }
    [[nodiscard, gnu::always_inline]] SpanPlace find(double t) const {
        if (period_ > 0.0) t -= std::floor((t - first_break_) / period_) * period_;
        if (scale_.size() == 1) return {0, (t - first_break_) * first_scale_ - 1.0, first_scale_};
        const double bucket = (t - first_break_) * buckets_per_unit_;
        const auto last = double(first_.size() - 1);
        auto span = std::size_t(first_[std::size_t(std::clamp(bucket, 0.0, last))]);
        while (span + 2 < breaks_.size() && breaks_[span + 1] <= t) ++span;
        const double scale = scale_[span];
        return {int(span), (t - breaks_[span]) * scale - 1.0, scale};
    }

  private:
    Values breaks_, scale_;
    double period_, buckets_per_unit_;
    // Kept beside each other: with many faces, places in memory are what a query pays for.
    double first_break_ = 0.0, first_scale_ = 0.0;
    std::pmr::vector<int> first_;
};

}  // namespace patchwright::occ
