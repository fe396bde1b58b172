// Fits by interpolation against the kernel's distances.
#include "occ/shapes.h"

#include <patchwright/fit/fit.h>
#include <patchwright/mesh/obj.h>
#include <patchwright/subd/limit_mask.h>

#include <catch2/catch.hpp>

#include <filesystem>

using namespace patchwright;

TEST_CASE("limit points of all vertices lie on the sample wing", "[occ][oracle]") {
    const std::filesystem::path folder = std::filesystem::path(PATCHWRIGHT_SAMPLES_DIR) / "wing";
    const occ::CadModel model = occ::read_cad(folder / "wing.igs").model;
    const occ::CadReference reference(model);
    const mesh::Cage cage = mesh::read_obj(folder / "wing_cage.obj").cage;
    const fit::FitResult result = fit::fit(cage, reference, {.interpolate = true});
    const double limit = fit::interpolation_limit_rel * reference.bounds().diagonal();
    const TopoDS_Shape faces = test::faces_only(model.impl().shape);
    double farthest = 0.0, before = 0.0;
    for (const mesh::VertexId v : cage.topology->vertices()) {
        farthest =
            std::max(farthest, test::kernel_distance(faces, subd::limit_position(result.cage, v)));
        before = std::max(before, test::kernel_distance(faces, subd::limit_position(cage, v)));
    }
    CAPTURE(farthest, before, limit);
    CHECK(farthest <= limit);
    CHECK(before > 1e3 * limit);
    // Creases are on sharp curves, where the given cage's were not.
    CHECK(result.levels[0].chains_on_features > 0);
    for (const mesh::EdgeId e : cage.topology->edges()) {
        if (!std::isinf(cage.topology->sharpness(e))) continue;
        for (const mesh::VertexId v : {cage.topology->start(e), cage.topology->end(e)}) {
            const auto hit = reference.feature_point(subd::limit_position(result.cage, v),
                                                     geom::FeatureKind::Sharp);
            const auto corner = reference.feature_point(subd::limit_position(result.cage, v),
                                                        geom::FeatureKind::Corner);
            REQUIRE(hit.has_value());
            REQUIRE(corner.has_value());
            // The file's curves end up to their tolerance from its corners.
            CHECK(std::min(hit->distance, corner->distance) <= limit);
        }
    }
}
