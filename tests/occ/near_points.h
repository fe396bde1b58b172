// Points near a model to ask for foot points.
#pragma once

#include <patchwright/occ/cad_reference.h>

#include <random>
#include <vector>

namespace patchwright::test {

/// Points at up to `reach` from points on the model, in random directions.
inline std::vector<geom::Vec3> near_points(const occ::CadReference& reference, double reach,
                                           int count, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const auto samples = reference.sample(10 * count);
    std::vector<geom::Vec3> points;
    for (int i = 0; i < count; ++i) {
        const auto& sample = samples[std::size_t(unit(random) * double(samples.size() - 1))];
        const geom::Vec3 direction =
            geom::Vec3(normal(random), normal(random), normal(random)).normalized();
        points.push_back(sample.point + reach * unit(random) * direction);
    }
    return points;
}

}  // namespace patchwright::test
