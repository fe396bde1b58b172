#include "measure/limit_sites.h"

namespace patchwright::measure {

subd::ParameterSet interior_grid(int n) {
    subd::ParameterSet set;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) set.emplace_back((i + 0.5) / n, (j + 0.5) / n);
    }
    return set;
}

subd::ParameterSet closed_grid(int n) {
    subd::ParameterSet set;
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) set.emplace_back(double(i) / n, double(j) / n);
    }
    return set;
}

std::vector<subd::Site> face_sites(const mesh::Topology& topology) {
    std::vector<subd::Site> sites;
    for (const mesh::FaceId f : topology.faces()) {
        const int sectors = topology.size(f) == 4 ? 1 : topology.size(f);
        for (int s = 0; s < sectors; ++s) sites.push_back({f, s, 0});
    }
    return sites;
}

}  // namespace patchwright::measure
