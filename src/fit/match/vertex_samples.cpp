#include "fit/match/vertex_samples.h"

#include <algorithm>

namespace patchwright::fit {

using geom::Vec3;

namespace {

constexpr int sides = 4;
// Weight of a sample, where others have 1: there are few of them, and faces next to a dart must not
// pull it from its curve (features_test: a crease that ends within the surface).
constexpr double vertex_weight = 3.0;

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

VertexSamples::VertexSamples(const mesh::Topology& topology, const CurveSampling& curves,
                             const FeatureMatch& match, const geom::ReferenceSurface& reference)
    : match_(match), reference_(reference) {
    const auto sample_of = [&](const CurveTarget& target) {
        VertexSample sample{vertex_site(topology, target.vertex), target.chain, target.point};
        sample.site.set += sides;
        return sample;
    };
    for (const CurveTarget& dart : match.darts) on_curves_.push_back(sample_of(dart));
    on_faces_ = on_curves_;
    for (const CurveTarget& turn : match.turns) on_curves_.push_back(sample_of(turn));
    for (const CurveTarget& dart : match.darts) {
        const EdgeChain& chain = curves.chains[std::size_t(dart.chain)];
        // Two edges have four sites where faces are no quads.
        const std::size_t last = std::min<std::size_t>(4, chain.sites.size());
        const bool at_start = chain.vertices.front() == dart.vertex;
        for (std::size_t k = 0; k < last; ++k) {
            const auto& site = chain.sites[at_start ? k : chain.sites.size() - 1 - k];
            on_faces_.push_back({curves.sites[std::size_t(site.first)], dart.chain, std::nullopt});
        }
    }
}

std::vector<subd::Site> VertexSamples::after_curves(std::vector<subd::Site> sites) const {
    for (const VertexSample& sample : on_curves_) sites.push_back(sample.site);
    return sites;
}

std::vector<subd::Site> VertexSamples::after_faces(std::vector<subd::Site> sites) const {
    for (const VertexSample& sample : on_faces_) {
        sites.push_back(sample.site);
        ++sites.back().set;
    }
    return sites;
}

Eigen::Index VertexSamples::rows_before(const subd::LimitOperator& samples, bool of_curves) const {
    const auto& rows = samples.site_rows();
    return rows[rows.size() - 1 - samples_of(of_curves).size()];
}

void VertexSamples::project(const subd::LimitOperator& samples, Projection& p) const {
    const auto& rows = samples.site_rows();
    const auto& own = samples_of(p.of_curves);
    const std::size_t first = rows.size() - 1 - own.size();
    for (std::size_t site = first; site + 1 < rows.size(); ++site) {
        const VertexSample& sample = own[site - first];
        for (auto row = rows[site]; row < rows[site + 1]; ++row) {
            const FeaturePath& path = match_.paths[std::size_t(sample.chain)];
            const Vec3 target =
                sample.place
                    ? *sample.place
                    : nearest_on_path(reference_, path, p.limit.row(row).transpose()).point;
            p.target.row(row) = target.transpose();
            p.weights.weight[row] = vertex_weight;
            p.normals.row(row).setZero();
            p.jacobian_ratio[row] = 1.0;
        }
    }
}

}  // namespace patchwright::fit
