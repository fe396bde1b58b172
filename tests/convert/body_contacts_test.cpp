// Bodies that cross: a fault of a conversion only where those of the input do not.
#include "convert/body_contacts.h"

#include "support/cages.h"

#include <patchwright/convert/convert.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/occ/cad_reference.h>
#include <patchwright/patch/extract.h>

#include <catch2/catch.hpp>

#include <filesystem>

using namespace patchwright;

namespace {

/// The limit surfaces of two cubes of edge 2, the second moved: rounded bodies in one cage.
mesh::Cage two_bodies(const geom::Vec3& apart) {
    std::vector<geom::Vec3> points;
    std::vector<std::vector<int>> faces;
    for (const geom::Vec3& at : {geom::Vec3(0, 0, 0), apart}) {
        const mesh::Cage cube = test::cube(2.0);
        const int first = int(points.size());
        for (Eigen::Index i = 0; i < cube.points.rows(); ++i)
            points.emplace_back(cube.points.row(i).transpose() + at);
        for (std::vector<int> face : test::cube_faces) {
            for (int& vertex : face) vertex += first;
            faces.push_back(std::move(face));
        }
    }
    return test::make_cage(points, faces);
}

occ::CadModel model_of(const mesh::Cage& cage) {
    return occ::assemble(patch::extract(cage).patches);
}

/// Half the width of the limit surface of a cube of edge 2 along an axis through its faces.
double half_width() {
    const auto bodies = occ::body_references(model_of(two_bodies({10, 0, 0})));
    return bodies.front().surface->foot_point({5, 0, 0}).point.x();
}

}  // namespace

TEST_CASE("bodies meet where they cross or touch, and nowhere else", "[convert][oracle]") {
    const double width = half_width();
    const auto meet = [&](double apart, const geom::Vec3& point) {
        convert::BodySurfaces bodies;
        for (const auto& body : occ::body_references(model_of(two_bodies({apart, 0, 0}))))
            bodies.push_back(body.surface);
        return convert::bodies_meet(bodies, point, 0.1, 1e-6);
    };
    // They cross in a curve halfway between them; its points are found from beside it.
    const double apart = 1.5 * width;
    const auto bodies = occ::body_references(model_of(two_bodies({apart, 0, 0})));
    geom::Vec3 on_curve(apart / 2, 1.0, 0.0);
    for (int step = 0; step < 20; ++step) {
        const geom::FootPoint foot = bodies.front().surface->foot_point(on_curve);
        on_curve.y() += (foot.point - on_curve).dot(foot.normal) / foot.normal.y();
    }
    CHECK(meet(apart, on_curve));
    CHECK(meet(apart, on_curve + geom::Vec3(0.03, -0.04, 0.02)));
    // Near one of them only, and near none.
    CHECK_FALSE(meet(apart, {-width, 0, 0}));
    CHECK_FALSE(meet(apart, {apart / 2, 5.0, 0.0}));
    // They touch; and they are apart by less than the reach.
    CHECK(meet(2 * width, {width, 0, 0}));
    CHECK_FALSE(meet(2 * width + 0.01, {width, 0, 0}));
}

TEST_CASE("bodies that cross in the input may cross in the output", "[convert]") {
    const std::filesystem::path folder = std::filesystem::temp_directory_path();
    const std::string stem = "patchwright_crossing_" + std::to_string(getpid());
    const std::filesystem::path input = folder / (stem + "_in.step"),
                                output = folder / (stem + ".step");
    const mesh::Cage cage = two_bodies({1.2, 0.1, 0.2});
    const occ::CadModel model = model_of(cage);
    {
        const auto file = std::make_shared<base::PendingFile>(input);
        occ::write_cad(model, *file, {});
        base::OutputSet outputs;
        outputs.add(file);
        outputs.commit();
    }
    const convert::Source source = convert::read_source(input);
    CHECK(source.bodies == 2);
    const convert::Conversion done = convert::convert(
        source, output, {.tolerance_mm = 1e-3 * source.input.diagonal, .cage = cage});
    std::filesystem::remove(input);
    std::filesystem::remove(output);
    REQUIRE(done.kept);
    const convert::Attempt& best = done.attempts[*done.kept];
    CHECK(best.verdict.met());
    CHECK(best.shape.self_intersections.empty());
    CHECK(best.shape.bodies == 2);

    // By themselves they cross, and no face meets another one of its body.
    const convert::Shape shape = convert::make_shape(cage, {}, {std::nullopt, 1e-3});
    const convert::ShapeFigures figures = convert::inspect_shape(shape, shape.model, "");
    CHECK_FALSE(figures.crossing_bodies.empty());
    CHECK(figures.self_intersections.empty());
    CHECK(convert::crossing_notice(figures).has_value());
}
