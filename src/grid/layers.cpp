#include "grid/far/far_field.h"
#include "grid/layer_rule.h"
#include "grid/marcher.h"
#include "grid/memory.h"

#include <patchwright/base/parallel.h>
#include <patchwright/grid/layers.h>

#include <algorithm>
#include <atomic>
#include <optional>

namespace patchwright::grid {

namespace {

/// Where steps had to be shortened, layers are marched anew with less growth from the surface on:
/// points that came less than the first share of their thickness get the second one of what they
/// came. The third is how often at most; the last march shortens what is left.
constexpr double full_share = 0.95, room_share = 0.8;
constexpr int most_marches = 12;

}  // namespace

struct LayerGrid::State {
    FrontMesh mesh;
    std::vector<geom::Points> fronts;
    double thinnest = 1.0;
    bool has_far_field = false;

    explicit State(const Plan& plan) : mesh(plan) {}

    /// Marches all fronts anew.
    /// @return  per point the share of the thickness that it came
    std::vector<double> march(const std::vector<LayerRule>& rules, const LayerOptions& options) {
        const std::size_t count = mesh.size();
        fronts.assign(1, mesh.surface());
        Marcher marcher(mesh);
        std::vector<double> heights(count), shares(count), came(count, 0.0), asked(count, 0.0);
        for (std::size_t p = 0; p < count; ++p) heights[p] = rules[p].first_mm;
        for (int k = 0; k < options.cells; ++k) {
            base::report_progress(options.progress, "layers", double(k) / options.cells);
            fronts.push_back(marcher.march(fronts.back(), heights, std::min(2 + k, 30), shares));
            for_points(count, [&](std::size_t p) {
                came[p] += shares[p] * heights[p];
                asked[p] += heights[p];
                heights[p] *= rules[p].growth;
            });
        }
        for_points(count, [&](std::size_t p) { came[p] /= asked[p]; });
        return came;
    }

    /// No thickness is more than a neighbour's and its distance: fronts stay flatter than 45
    /// degrees to the surface.
    void grade(std::vector<double>& thickness) const {
        std::vector<double> next = thickness;
        for (bool changed = true; changed;) {
            std::atomic<bool> any = false;
            for_points(mesh.size(), [&](std::size_t p) {
                for (const FrontMesh::Corner& c : mesh.corners(p)) {
                    for (const std::int32_t q : {c.next, c.previous}) {
                        const double distance =
                            (mesh.surface().row(Eigen::Index(p)) - mesh.surface().row(q)).norm();
                        next[p] = std::min(next[p], thickness[std::size_t(q)] + distance);
                    }
                }
                if (next[p] < thickness[p]) any = true;
            });
            thickness = next;
            changed = any;
        }
    }
};

LayerGrid::LayerGrid(const Plan& plan, const LayerOptions& options) : plan_(plan) {
    const LayerRule wanted = wanted_rule(options);
    require_memory(plan, options.cells + 1, options.cells + 1);
    state_ = std::make_unique<State>(plan);
    std::optional<Sphere> sphere;
    if (options.far_field_mm > 0.0)
        sphere = enclosing_sphere(plan, state_->mesh, options.far_field_mm);
    const std::size_t count = state_->mesh.size();
    std::vector<LayerRule> rules(count, wanted);
    std::vector<double> thickness(count, wanted.thickness(options.cells));
    for (int march = 0;; ++march) {
        const std::vector<double> came = state_->march(rules, options);
        if (march == most_marches ||
            std::all_of(came.begin(), came.end(), [](double c) { return c >= full_share; }))
            break;
        for (std::size_t p = 0; p < count; ++p)
            if (came[p] < full_share)
                thickness[p] = std::max(room_share * came[p] * thickness[p],
                                        shortest_step * wanted.thickness(options.cells));
        state_->grade(thickness);
        for_points(count,
                   [&](std::size_t p) { rules[p] = wanted.within(thickness[p], options.cells); });
    }
    double height = wanted.first_mm;
    for (std::size_t k = 1; k < state_->fronts.size(); ++k, height *= wanted.growth)
        state_->thinnest = std::min(
            state_->thinnest,
            (state_->fronts[k] - state_->fronts[k - 1]).rowwise().norm().minCoeff() / height);
    if (!sphere) return;
    const auto last = state_->fronts.end();
    for (geom::Points& front : far_fronts(plan, state_->mesh, *sphere, {last[-2], last[-1]},
                                          {options.growth, options.progress}))
        state_->fronts.push_back(std::move(front));
    state_->has_far_field = true;
}
LayerGrid::~LayerGrid() = default;

int LayerGrid::layers() const { return static_cast<int>(state_->fronts.size()); }

bool LayerGrid::has_far_field() const { return state_->has_far_field; }

double LayerGrid::thinnest() const { return state_->thinnest; }

void LayerGrid::evaluate(int block, BlockPoints& points) const {
    const auto [ni, nj] = plan_.size(block);
    points.ni = ni;
    points.nj = nj;
    points.nk = layers();
    for (auto& c : points.coordinates) c.resize(points.count());
    const std::vector<std::int32_t>& numbers = state_->mesh.numbers(block);
    base::parallel_for(state_->fronts.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            for (std::size_t n = 0; n < numbers.size(); ++n) {
                for (std::size_t c = 0; c < 3; ++c) {
                    points.coordinates[c][k * numbers.size() + n] =
                        state_->fronts[k](numbers[n], Eigen::Index(c));
                }
            }
        }
    });
}

}  // namespace patchwright::grid
