#include "occ/foot/reference_sampling.h"

#include <algorithm>
#include <cmath>

namespace patchwright::occ {

using geom::Vec3;
using Sample = geom::SurfaceSample;

namespace {

constexpr int min_per_face = 8;
constexpr int min_per_edge = 3;

// Half of the samples go by area, half by area times bend: between samples that are h apart, the
// distance to another surface changes by up to h^2 / 8 of the bend.
class Density {
  public:
    explicit Density(const SearchModel& model) : longest_(1.0 / std::max(model.size, 1e-300)) {
        for (const MeshTriangle& t : model.mesh.triangles) {
            area_ += t.area;
            bent_ += t.area * bend(t);
        }
    }
    [[nodiscard]] double area() const { return area_; }
    /// Share of the samples that a triangle gets.
    [[nodiscard]] double share(const MeshTriangle& t) const {
        if (!(area_ > 0.0)) return 0.0;
        if (!(bent_ > 0.0)) return t.area / area_;
        return 0.5 * t.area / area_ + 0.5 * t.area * bend(t) / bent_;
    }

  private:
    // Between that of the whole model's size and a hundred times more, so that a fillet does not
    // take all.
    [[nodiscard]] double bend(const MeshTriangle& t) const {
        return std::clamp(std::max(t.bend_out, t.bend_in), longest_, 100.0 * longest_);
    }
    double longest_, area_ = 0.0, bent_ = 0.0;
};

// Parameters inside the face near the given point of a triangle: chords of a hollow boundary stand
// out of the trim, points towards the middle of the triangle do not.
std::optional<Vec2> inside_trim(const FaceSurface& surface, const MeshTriangle& t,
                                const Vec3& weights) {
    for (const double pull : {0.0, 0.5, 1.0}) {
        const Vec3 w = (1 - pull) * weights + pull * Vec3::Constant(1.0 / 3.0);
        const Vec2 uv = w[0] * t.uv[0] + w[1] * t.uv[1] + w[2] * t.uv[2];
        if (surface.contains(uv)) return uv;
    }
    return std::nullopt;
}

// Equal steps along the triangles' summed share choose the triangle, the R2 sequence (Roberts,
// 2018) the place in it.
void sample_face(const SearchModel& model, const Density& density, std::size_t face, int count,
                 std::vector<Sample>& samples) {
    const std::size_t begin = model.mesh.first[face], end = model.mesh.first[face + 1];
    double whole = 0.0;
    for (std::size_t i = begin; i < end; ++i) whole += density.share(model.mesh.triangles[i]);
    if (!(whole > 0.0)) return;
    std::size_t at = begin;
    double passed = 0.0;
    for (int k = 0; k < count; ++k) {
        const double target = whole * (k + 0.5) / count;
        while (at + 1 < end && passed + density.share(model.mesh.triangles[at]) < target)
            passed += density.share(model.mesh.triangles[at++]);
        constexpr double step_a = 0.7548776662466927, step_b = 0.5698402909980532;
        double a = std::fmod(0.5 + step_a * k, 1.0), b = std::fmod(0.5 + step_b * k, 1.0);
        if (a + b > 1.0) {
            a = 1.0 - a;
            b = 1.0 - b;
        }
        const MeshTriangle& t = model.mesh.triangles[at];
        // The fewer samples its share brings, the more area each of them stands for.
        const double weight = t.area * whole / (density.share(t) * count);
        if (const auto uv = inside_trim(model.surfaces[face], t, Vec3(1.0 - a - b, a, b)))
            samples.push_back({model.surfaces[face].at(*uv), model.surfaces[face].normal(*uv),
                               static_cast<int>(face), weight});
    }
}

double length_of(const ModelEdge& edge) {
    constexpr int pieces = 32;
    double length = 0.0;
    Vec3 last = edge.at(edge.first);
    for (int i = 1; i <= pieces; ++i) {
        const Vec3 next = edge.at(edge.first + (edge.last - edge.first) * i / pieces);
        length += (next - last).norm();
        last = next;
    }
    return length;
}

void sample_edge(const SearchModel& model, const ModelEdge& edge, double spacing,
                 std::vector<Sample>& samples) {
    const double wanted = std::min(length_of(edge) / spacing, 1e6);
    const int count = std::max(min_per_edge, static_cast<int>(wanted));
    for (int i = 0; i < count; ++i) {
        const double t = edge.first + (edge.last - edge.first) * (i + 0.5) / count;
        samples.push_back({edge.at(t), normal_beside(edge, edge.uses.front(), t, model.surfaces),
                           edge.uses.front().face, 0.0});
    }
}

void sample_vertices(const SearchModel& model, std::vector<Sample>& samples) {
    std::vector<bool> done(model.network.vertices.size(), false);
    for (const ModelEdge& edge : model.network.edges) {
        for (const auto& [vertex, t] :
             {std::pair(edge.start, edge.first), std::pair(edge.end, edge.last)}) {
            if (vertex < 0 || done[std::size_t(vertex)]) continue;
            done[std::size_t(vertex)] = true;
            samples.push_back({model.network.vertices[std::size_t(vertex)],
                               normal_beside(edge, edge.uses.front(), t, model.surfaces),
                               edge.uses.front().face, 0.0});
        }
    }
}

}  // namespace

std::vector<Sample> sample_model(const SearchModel& model, int count) {
    std::vector<Sample> samples;
    const Density density(model);
    for (std::size_t face = 0; face < model.surfaces.size(); ++face) {
        double share = 0.0;
        for (std::size_t i = model.mesh.first[face]; i < model.mesh.first[face + 1]; ++i)
            share += density.share(model.mesh.triangles[i]);
        const int wanted = static_cast<int>(std::round(count * share));
        sample_face(model, density, face, std::max(min_per_face, wanted), samples);
    }
    const double spacing = std::max(std::sqrt(density.area() / count), 1e-6 * model.size);
    for (const ModelEdge& edge : model.network.edges) sample_edge(model, edge, spacing, samples);
    sample_vertices(model, samples);
    return samples;
}

}  // namespace patchwright::occ
