#include "fit/match/dart_samples.h"

#include <algorithm>

namespace patchwright::fit {

using geom::Vec3;

namespace {

constexpr int sides = 4;
// Weight of a sample of a crease, where those of the surface have 1: there are few of them, and
// faces next to a dart must not pull it from its curve (features_test: a crease that ends within
// the surface).
constexpr double dart_weight = 3.0;

}  // namespace

std::vector<subd::ParameterSet> curve_sets(int n) {
    std::vector<subd::ParameterSet> sets = side_sets(n);
    for (subd::ParameterSet& set : corner_sets()) sets.push_back(std::move(set));
    return sets;
}

std::vector<subd::ParameterSet> surface_sets(int n) {
    std::vector<subd::ParameterSet> sets = curve_sets(n);
    sets.insert(sets.begin(), interior_grid(n));
    return sets;
}

DartSamples::DartSamples(const mesh::Topology& topology, const CurveSampling& curves,
                         const FeatureMatch& match, const geom::ReferenceSurface& reference)
    : match_(match), reference_(reference) {
    for (const DartTarget& dart : match.darts) {
        samples_.push_back({vertex_site(topology, dart.vertex), dart.chain, dart.point});
        samples_.back().site.set += sides;
    }
    for (const DartTarget& dart : match.darts) {
        const EdgeChain& chain = curves.chains[std::size_t(dart.chain)];
        // Two edges have four sites where faces are no quads.
        const std::size_t last = std::min<std::size_t>(4, chain.sites.size());
        const bool at_start = chain.vertices.front() == dart.vertex;
        for (std::size_t k = 0; k < last; ++k) {
            const auto& site = chain.sites[at_start ? k : chain.sites.size() - 1 - k];
            samples_.push_back({curves.sites[std::size_t(site.first)], dart.chain, std::nullopt});
        }
    }
}

std::size_t DartSamples::count(bool of_curves) const {
    return of_curves ? match_.darts.size() : samples_.size();
}

std::vector<subd::Site> DartSamples::after_curves(std::vector<subd::Site> sites) const {
    for (std::size_t k = 0; k < count(true); ++k) sites.push_back(samples_[k].site);
    return sites;
}

std::vector<subd::Site> DartSamples::after_faces(std::vector<subd::Site> sites) const {
    for (const DartSample& sample : samples_) {
        sites.push_back(sample.site);
        ++sites.back().set;
    }
    return sites;
}

Eigen::Index DartSamples::rows_before(const subd::LimitOperator& samples, bool of_curves) const {
    const auto& rows = samples.site_rows();
    return rows[rows.size() - 1 - count(of_curves)];
}

void DartSamples::project(const subd::LimitOperator& samples, Projection& p) const {
    const auto& rows = samples.site_rows();
    const std::size_t first = rows.size() - 1 - count(p.of_curves);
    for (std::size_t site = first; site + 1 < rows.size(); ++site) {
        const DartSample& sample = samples_[site - first];
        for (auto row = rows[site]; row < rows[site + 1]; ++row) {
            const FeaturePath& path = match_.paths[std::size_t(sample.chain)];
            const Vec3 target =
                sample.place
                    ? *sample.place
                    : nearest_on_path(reference_, path, p.limit.row(row).transpose()).point;
            p.target.row(row) = target.transpose();
            p.weights.weight[row] = dart_weight;
            p.normals.row(row).setZero();
            p.jacobian_ratio[row] = 1.0;
        }
    }
}

}  // namespace patchwright::fit
