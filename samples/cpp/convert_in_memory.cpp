// Triangles to B-spline patches and a solid without any file: what a program does that has the one
// in memory and wants the other.
#include <patchwright/cage/make_cage.h>
#include <patchwright/convert/shape.h>
#include <patchwright/fit/fit.h>
#include <patchwright/geom/mesh_reference.h>
#include <patchwright/occ/cad_reference.h>

#include <cmath>
#include <iostream>
#include <numbers>

namespace pw = patchwright;

/// A closed bulb with a waist, 200 mm long, in rings of triangles.
pw::geom::TriangleMesh bulb(int rings, int around) {
    using std::numbers::pi;
    pw::geom::TriangleMesh mesh;
    mesh.points.resize(2 + (rings - 1) * around, 3);
    mesh.points.row(0) << 0, 0, -100;
    mesh.points.row(1) << 0, 0, 100;
    const auto number = [&](int ring, int i) {
        return ring == 0 ? 0 : ring == rings ? 1 : 2 + (ring - 1) * around + i % around;
    };
    for (int ring = 0; ring < rings; ++ring) {
        const double polar = pi * ring / rings, z = -100 * std::cos(polar);
        const double radius = 60 * std::sin(polar) * (1 - 0.3 * std::exp(-z * z / 2500));
        for (int i = 0; i < around; ++i) {
            const double angle = 2 * pi * i / around;
            if (ring > 0)
                mesh.points.row(number(ring, i)) << radius * std::cos(angle),
                    radius * std::sin(angle), z;
            const int a = number(ring, i), b = number(ring, i + 1);
            const int c = number(ring + 1, i + 1), d = number(ring + 1, i);
            if (ring > 0) mesh.triangles.push_back({a, b, c});
            if (ring < rings - 1) mesh.triangles.push_back({a, c, d});
        }
    }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

int main() {
    pw::geom::TriangleMesh triangles = bulb(160, 200);
    pw::geom::make_sound(triangles, "bulb");
    const pw::geom::MeshReference model(std::move(triangles));
    const double tolerance_rel = 1e-3;
    const double tolerance_mm = tolerance_rel * model.bounds().diagonal();

    const auto made = pw::cage::make_cage(model, {.tolerance_rel = tolerance_rel});
    const auto fitted = pw::fit::fit(made.cage, model, {.tolerance_mm = tolerance_mm});
    const auto shape = pw::convert::make_shape(fitted.cage, {}, {.whole_mm = tolerance_mm});
    std::cout << shape.surfaces.size() << " patches, the first of "
              << shape.surfaces.front().points.rows() << " control points\n";

    // shape.model is the solid: occ::write_cad(shape.model, "bulb.step") would write it.
    const pw::occ::CadReference solid(shape.model);
    auto figures = pw::convert::verdict_figures(
        pw::convert::inspect_shape(shape, shape.model, "bulb"), shape.closed);
    figures.tolerance_mm = tolerance_mm;
    pw::convert::add_deviation(figures, pw::convert::compare(solid, model, 20000, tolerance_mm));
    const pw::measure::Verdict verdict = pw::measure::assess(figures);
    std::cout << verdict.sentence(pw::base::LengthUnit::Millimetre) << "\n";
    return verdict.met() ? 0 : 3;
}
