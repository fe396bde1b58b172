#include "cage/sections/wing_columns.h"

#include <algorithm>
#include <array>

namespace patchwright::cage {

namespace {

// Where the points of a section are from the nose to the trailing edge, as shares of a side's
// length: denser towards the nose, as the curvature of usual sections is.
constexpr std::array<double, 7> usual_shares{1.0, 0.825, 0.565, 0.385, 0.21, 0.105, 0.035};
// How far from the nose the points next to it lie, in nose radii: where a section has turned by
// about 50 degrees. As shares of a side's length, which bound it: sharper noses would get quads too
// narrow, blunter ones leave the next point of usual_shares.
constexpr double beside_nose_radii = 0.9, nearest_to_nose = 0.003, farthest_from_nose = 0.02;
// Halvings that find where the body ends: 24 leave 1e-7 of the way.
constexpr int halvings = 24;

}  // namespace

std::vector<double> column_shares(const std::vector<WingSection>& sections, int columns) {
    std::vector<double> radii;
    for (const WingSection& s : sections)
        radii.push_back(s.nose_radius / (0.5 * (s.length(0) + s.length(1))));
    std::nth_element(radii.begin(), radii.begin() + std::ptrdiff_t(radii.size() / 2), radii.end());
    const double nose = std::clamp(beside_nose_radii * radii[radii.size() / 2], nearest_to_nose,
                                   farthest_from_nose);
    const auto& usual = usual_shares;
    const int inner = columns - 1;
    std::vector<double> shares;
    for (int j = 0; j < inner; ++j) {
        const double x = double(j) / (inner - 1) * (usual.size() - 1);
        const auto i = std::min(std::size_t(x), usual.size() - 2);
        shares.push_back(1.0 - (usual[i] + (x - double(i)) * (usual[i + 1] - usual[i])));
    }
    shares.push_back(1.0 - nose);
    return shares;
}

double way_out(const geom::Vec3& from, const geom::Vec3& way, const geom::ModelSurface& reference) {
    double in = 0.0, out = 1.0;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (in + out);
        const geom::Vec3 p = from + middle * way;
        const geom::FootPoint foot = reference.foot_point(p);
        ((p - foot.point).dot(foot.normal) < 0.0 ? in : out) = middle;
    }
    return in * way.norm();
}

}  // namespace patchwright::cage
