#include "cage/sections/spine.h"

#include <algorithm>
#include <limits>

namespace patchwright::cage {

using geom::Vec3;

Spine::Spine(const Vec3& axis) : planes_{{Vec3::Zero(), axis}}, heights_{0.0} {}

Spine::Spine(const std::vector<Plane>& planes, const Vec3& chordwise)
    : planes_(planes), heights_{0.0}, chordwise_(chordwise) {
    for (std::size_t i = 0; i + 1 < planes.size(); ++i)
        heights_.push_back(heights_.back() + across(planes[i + 1].point - planes[i].point).norm());
}

Vec3 Spine::across(const Vec3& v) const { return v - v.dot(chordwise_) * chordwise_; }

double Spine::distance(std::size_t plane, const Vec3& p) const {
    return (p - planes_[plane].point).dot(planes_[plane].normal);
}

std::size_t Spine::segment_near(const Vec3& p) const {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < planes_.size(); ++i) {
        const Vec3 start = across(planes_[i].point - p), end = across(planes_[i + 1].point - p);
        const Vec3 along = end - start;
        const double share = std::clamp(-start.dot(along) / along.squaredNorm(), 0.0, 1.0);
        const double squared = (start + share * along).squaredNorm();
        if (squared >= least) continue;
        least = squared;
        nearest = i;
    }
    return nearest;
}

double Spine::height(const Vec3& p) const {
    const std::size_t last = planes_.size() - 1, i = segment_near(p), j = std::min(i + 1, last);
    const double above = distance(i, p), below = -distance(j, p);
    if (i == 0 && above < 0.0) return heights_[0] + above;
    if (j == last && below < 0.0) return heights_[j] - below;
    const double share = above + below > 0.0 ? std::clamp(above / (above + below), 0.0, 1.0) : 0.5;
    return heights_[i] + share * (heights_[j] - heights_[i]);
}

std::vector<double> Spine::inner_heights() const {
    if (heights_.size() < 3) return {};
    return {heights_.begin() + 1, heights_.end() - 1};
}

Spine::Between Spine::between(double height) const {
    const auto next = std::upper_bound(heights_.begin(), heights_.end(), height);
    if (next == heights_.begin()) return {0, 0, 0.0};
    const auto i = std::size_t(next - heights_.begin()) - 1;
    if (next == heights_.end()) return {i, i, 0.0};
    return {i, i + 1, (height - heights_[i]) / (heights_[i + 1] - heights_[i])};
}

Vec3 Spine::direction(double height) const {
    const auto [i, j, share] = between(height);
    if (i == j) return planes_[i].normal;
    return ((1.0 - share) * planes_[i].normal + share * planes_[j].normal).normalized();
}

double Spine::offset(const Vec3& p, double height) const {
    const auto [i, j, share] = between(height);
    if (i == j) return distance(i, p) - (height - heights_[i]);
    return (1.0 - share) * distance(i, p) + share * distance(j, p);
}

}  // namespace patchwright::cage
