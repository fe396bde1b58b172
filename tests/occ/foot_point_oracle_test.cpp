// A part of what check_footpoint does, short enough for every day.
#include "occ/foot_point_oracle.h"

#include <patchwright/occ/inspect.h>

#include <catch2/catch.hpp>

#include <filesystem>

using namespace patchwright;

TEST_CASE("foot points of files are no farther than the kernel's", "[occ][legacy][oracle]") {
    const std::filesystem::path samples = PATCHWRIGHT_SAMPLES_DIR;
    const std::filesystem::path legacy = PATCHWRIGHT_LEGACY_CAD_DIR;
    const std::vector<std::filesystem::path> files{
        samples / "wing" / "wing.igs",     legacy / "tigl_d150_wing.igs",
        legacy / "nosecone_sw.step",       legacy / "naca_wing_dealii.iges",
        legacy / "seat_cpacs.stp",         legacy / "dtmb5415_bow.iges",
        legacy / "c172_wing_pyspline.igs", legacy / "endplate_wing_vsp.stp"};
    for (const auto& file : files) {
        CAPTURE(file.string());
        if (!std::filesystem::exists(file)) {
            WARN("skipped: " << file.string() << " is not there");
            continue;
        }
        const occ::CadModel model = occ::read_cad(file).model;
        const occ::CadReference reference(model);
        const double size = reference.bounds().diagonal();
        const double tolerance = 1e-7 * size + occ::inspect(model).max_tolerance_mm;
        const test::OracleResult found = test::compare_with_kernel(
            reference, test::faces_only(model.impl().shape), 240, 2, tolerance);
        CAPTURE(found.worst.kind, found.worst.point.transpose());
        CHECK(found.points > 200);
        CHECK(found.kinds.size() == 6);
        CHECK(found.farther <= tolerance);
    }
}
