#include "reference_sampling.h"

#include <algorithm>
#include <cmath>

namespace patchwright::occ {

using geom::Vec3;
using Sample = CadReference::Sample;

namespace {

constexpr int min_per_face = 8;
constexpr int min_per_edge = 3;

double total_area(const SearchModel& model) {
    double area = 0.0;
    for (const MeshTriangle& t : model.mesh.triangles) area += t.area;
    return area;
}

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

// Equal steps along the triangles' summed area choose the triangle, the R2 sequence (Roberts, 2018)
// the place in it.
void sample_face(const SearchModel& model, std::size_t face, int count,
                 std::vector<Sample>& samples) {
    const std::size_t begin = model.mesh.first[face], end = model.mesh.first[face + 1];
    double area = 0.0;
    for (std::size_t i = begin; i < end; ++i) area += model.mesh.triangles[i].area;
    std::size_t at = begin;
    double passed = 0.0;
    for (int k = 0; k < count && begin < end; ++k) {
        const double target = area * (k + 0.5) / count;
        while (at + 1 < end && passed + model.mesh.triangles[at].area < target)
            passed += model.mesh.triangles[at++].area;
        constexpr double step_a = 0.7548776662466927, step_b = 0.5698402909980532;
        double a = std::fmod(0.5 + step_a * k, 1.0), b = std::fmod(0.5 + step_b * k, 1.0);
        if (a + b > 1.0) {
            a = 1.0 - a;
            b = 1.0 - b;
        }
        const MeshTriangle& t = model.mesh.triangles[at];
        if (const auto uv = inside_trim(model.surfaces[face], t, Vec3(1.0 - a - b, a, b)))
            samples.push_back({model.surfaces[face].at(*uv), model.surfaces[face].normal(*uv),
                               static_cast<int>(face)});
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
                           edge.uses.front().face});
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
                               edge.uses.front().face});
        }
    }
}

}  // namespace

std::vector<Sample> sample_model(const SearchModel& model, int count) {
    std::vector<Sample> samples;
    const double area = total_area(model);
    for (std::size_t face = 0; face < model.surfaces.size(); ++face) {
        double share = 0.0;
        for (std::size_t i = model.mesh.first[face]; i < model.mesh.first[face + 1]; ++i)
            share += model.mesh.triangles[i].area;
        const double wanted = area > 0.0 ? std::round(count * share / area) : 0.0;
        sample_face(model, face, std::max(min_per_face, static_cast<int>(wanted)), samples);
    }
    const double spacing = std::max(std::sqrt(area / count), 1e-6 * model.size);
    for (const ModelEdge& edge : model.network.edges) sample_edge(model, edge, spacing, samples);
    sample_vertices(model, samples);
    return samples;
}

}  // namespace patchwright::occ
