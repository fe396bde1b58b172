#include "convert/bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace patchwright::convert {

namespace {

/// Of the check of one body, each way.
constexpr int least_samples = 1000;
/// Of one body: a box.
constexpr int least_faces = 6;
/// Of the model's size: largest distance of the triangles that a volume is summed over.
constexpr double deflection_rel = 1e-3;

/// Of faces without a solid, which the kernel gives no volume.
double enclosed_volume(const geom::ModelSurface& closed) {
    const geom::SurfaceMesh mesh = closed.surface_mesh(deflection_rel * closed.size());
    double volume = 0.0;
    for (const auto& t : mesh.triangles) {
        const geom::Vec3 a = mesh.points.row(t[0]), b = mesh.points.row(t[1]),
                         c = mesh.points.row(t[2]);
        volume += a.dot(b.cross(c)) / 6.0;
    }
    return std::abs(volume);
}

}  // namespace

bool by_bodies(const Source& source, const ConvertOptions& options) {
    return source.model && source.bodies > 1 && !options.cage;
}

std::vector<Body> bodies_of(const Source& source, const ConvertOptions& options,
                            const base::Progress& progress) {
    std::vector<std::string> names = occ::face_names(*source.model);
    for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i].empty()) names[i] = fmt::format("face_{}", i + 1);
    const occ::CadModel named = occ::with_face_names(*source.model, std::move(names));
    occ::ReferenceOptions reference = source.reference_options(progress);
    reference.size_mm = source.surface().size();
    std::vector<Body> bodies;
    double area = 0.0;
    for (occ::BodyReference& found : occ::body_references(named, reference)) {
        Body body{.source = {.model = occ::part_of(named, found.faces),
                             .cad = std::move(found.surface),
                             .input = source.input,
                             .bodies = 1,
                             .is_body = true,
                             .options = source.options},
                  .options = options};
        body.source.figures = solid_figures(source.input.file, *body.source.model);
        if (body.source.figures.closed)
            body.source.figures.volume = enclosed_volume(*body.source.cad);
        area += body.source.figures.area;
        bodies.push_back(std::move(body));
    }
    for (Body& body : bodies) {
        const double share = area > 0.0 ? body.source.figures.area / area : 1.0;
        const auto part = [&](int whole, int least) {
            return std::min(whole, std::max(least, int(std::lround(share * whole))));
        };
        body.options.samples = part(options.samples, least_samples);
        if (options.target_faces)
            body.options.target_faces = part(*options.target_faces, least_faces);
    }
    return bodies;
}

}  // namespace patchwright::convert
