#include "report/colour_scale.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>
#include <vector>

namespace patchwright::report {

base::Colour diverging_colour(double share) {
    constexpr double white = 0.93;
    const base::Colour& end = share < 0.0 ? scale_stops.front() : scale_stops.back();
    const double t = std::min(std::abs(share), 1.0);
    return {white + t * (end.red - white), white + t * (end.green - white),
            white + t * (end.blue - white)};
}

base::Colour face_colour(int face) {
    constexpr double golden = 0.61803398875, saturation = 0.45;
    const double hue = 6.0 * (face * golden - std::floor(face * golden));
    const double lightness = 0.5 + 0.14 * (face % 3);
    const double chroma = (1.0 - std::abs(2.0 * lightness - 1.0)) * saturation;
    const auto channel = [&](double offset) {
        const double place = std::fmod(hue + offset, 6.0);
        const double rise = std::clamp(std::min(place, 4.0 - place), 0.0, 1.0);
        return lightness + chroma * (rise - 0.5);
    };
    return {channel(2.0), channel(0.0), channel(4.0)};
}

double usual_curvature(std::initializer_list<const measure::Field*> fields) {
    constexpr double usual_share = 0.9;
    std::vector<std::pair<double, double>> parts;  // curvature, area
    double whole = 0.0;
    for (const measure::Field* field : fields) {
        if (field == nullptr) continue;
        for (const auto& [a, b, c] : field->triangles) {
            const auto point = [&](int i) { return geom::Vec3(field->points.row(i)); };
            const double area = 0.5 * (point(b) - point(a)).cross(point(c) - point(a)).norm();
            parts.emplace_back(std::abs(field->curvature[std::size_t(a)]), area);
            whole += area;
        }
    }
    std::sort(parts.begin(), parts.end());
    double passed = 0.0;
    for (const auto& [curvature, area] : parts)
        if ((passed += area) >= usual_share * whole && curvature > 0.0) return curvature;
    return 1.0;
}

}  // namespace patchwright::report
