// Chains of a cage whose shape has moved by more than what is between the curves they belong to.
#include <patchwright/fit/fit.h>
#include <patchwright/mesh/obj.h>
#include <patchwright/occ/cad_reference.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

using namespace patchwright;
using geom::Vec3;

namespace {

const std::filesystem::path folder = std::filesystem::path(PATCHWRIGHT_SAMPLES_DIR) / "wing";

/// Bent by `tip` at the tip, not at all at the root, with the square of the span.
mesh::Cage bent(mesh::Cage cage, const Vec3& tip) {
    const double span = cage.points.col(1).maxCoeff();
    for (Eigen::Index v = 0; v < cage.points.rows(); ++v)
        cage.points.row(v) += std::pow(cage.points(v, 1) / span, 2) * tip.transpose();
    return cage;
}

}  // namespace

TEST_CASE("a wing whose tip has moved keeps the edges of its trailing edge", "[occ][fit][oracle]") {
    const occ::CadReference wing(occ::read_cad(folder / "wing.step").model);
    const mesh::Cage cage = mesh::read_obj(folder / "wing_cage.obj").cage;
    // The trailing edge is 1.8 mm thick at the tip, whose both edges are one curve of the CAD.
    const fit::FitOptions options{
        .tolerance_mm = 2e-4 * wing.bounds().diagonal(), .max_levels = 0, .reverse_samples = 0};
    for (const Vec3& tip : {Vec3(0, 0, 0), Vec3(0, 0, 5), Vec3(0, 0, -10), Vec3(0, 0, -40),
                            Vec3(0, 0, 80), Vec3(20, 0, 0), Vec3(80, 0, 0), Vec3(0, 20, 0)}) {
        INFO("tip moved by " << tip.transpose());
        const fit::FitResult result = fit::fit(bent(cage, tip), wing, options);
        CHECK(result.levels[0].chains_on_features == 3);
        CHECK(result.levels[0].curve_max_mm < options.tolerance_mm);
    }
}
