#include "support/cages.h"

#include <patchwright/base/error.h>
#include <patchwright/cage/make_cage.h>
#include <patchwright/geom/mesh_reference.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/occ/cad_reference.h>
#include <patchwright/patch/extract.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <set>

namespace patchwright {
namespace {

struct Sample {
    occ::CadModel model;
    occ::CadReference reference;
};

const Sample& wing() {
    static const Sample sample = [] {
        occ::CadModel model = occ::read_cad(PATCHWRIGHT_SAMPLES_DIR "/wing/wing.step").model;
        occ::CadReference reference(model);
        return Sample{std::move(model), std::move(reference)};
    }();
    return sample;
}

double volume(const mesh::Cage& cage) {
    double sum = 0.0;
    for (const mesh::FaceId f : cage.topology->faces()) {
        const auto corners = cage.topology->corners(f);
        const auto at = [&](int k) {
            return geom::Vec3(cage.points.row(cage.topology->vertex(corners[k]).value));
        };
        for (int k = 1; k + 1 < corners.size(); ++k) sum += at(0).dot(at(k).cross(at(k + 1))) / 6.0;
    }
    return sum;
}

TEST_CASE("a model's triangles are one closed mesh with its features", "[layout]") {
    const geom::SurfaceMesh mesh = wing().reference.surface_mesh(1.0);
    std::map<std::pair<int, int>, int> uses;
    double sum = 0.0;
    for (const auto& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
        const geom::Vec3 a = mesh.points.row(t[0]), b = mesh.points.row(t[1]),
                         c = mesh.points.row(t[2]);
        sum += a.dot(b.cross(c)) / 6.0;
    }
    for (const auto& [side, count] : uses) {
        CHECK(count == 1);
        CHECK(uses.contains({side.second, side.first}));
    }
    // The sample's volume; chords of a convex section lose about a deflection times half the area.
    CHECK(sum == Approx(121602975.0).epsilon(0.01));
    std::map<int, double> length;
    for (const geom::FeatureSide& f : mesh.features)
        length[f.curve] += (mesh.points.row(f.v0) - mesh.points.row(f.v1)).norm();
    for (const auto& [curve, sampled] : length) {
        const auto& feature = wing().reference.features().curves[std::size_t(curve)];
        CHECK(feature.kind != geom::FeatureKind::Free);
        CHECK(sampled == Approx(feature.length).epsilon(0.01));
    }
}

TEST_CASE("a wing gets rings of quads with all extraordinary vertices at its ends", "[layout]") {
    const cage::CageResult result = cage::make_cage(wing().reference);
    const mesh::Topology& topology = *result.cage.topology;
    CHECK(result.method == cage::Method::Aligned);
    CHECK(topology.is_closed());
    CHECK(topology.all_quads());
    // The cage made by hand has 110.
    CHECK(topology.face_count() <= 165);
    const geom::Box3 box = wing().reference.bounds();
    for (const mesh::VertexId v : topology.vertices()) {
        if (!mesh::is_extraordinary(topology, v)) continue;
        const double y = result.cage.points(v.value, 1);
        CHECK((y < box.min.y() + 1.0 || y > 2790.0));
    }
    // Every sharp curve of the model is a line of creases: points along it are near one.
    std::vector<geom::Vec3> creases;
    for (const mesh::EdgeId e : topology.edges()) {
        if (topology.sharpness(e) == 0.0) continue;
        for (const double s : {0.0, 0.25, 0.5, 0.75})
            creases.emplace_back((1.0 - s) * result.cage.points.row(topology.start(e).value) +
                                 s * result.cage.points.row(topology.end(e).value));
    }
    for (const auto& sample : wing().reference.sample_curves(geom::FeatureKind::Sharp, 200.0)) {
        double nearest = 1e300;
        for (const geom::Vec3& p : creases) nearest = std::min(nearest, (p - sample.point).norm());
        CHECK(nearest < 120.0);  // a quarter of the longest edge
    }
    const auto& groups = topology.group_names();
    for (const char* name : {"upper", "lower", "nose", "te", "tip", "root"})
        CHECK(std::count(groups.begin(), groups.end(), name) == 1);
    // Sides of the nose's polygon lie outside the section, those elsewhere mostly inside.
    CHECK(volume(result.cage) == Approx(121602975.0).epsilon(0.05));
}

TEST_CASE("faces beside a wing's tip are about as long as each other", "[layout]") {
    // The borders of the sample's cap meet at the nose, 4 mm from the section where the tip begins;
    // elsewhere it is 25 mm from there.
    const mesh::Cage cage = cage::make_cage(wing().reference).cage;
    const mesh::Topology& t = *cage.topology;
    std::set<int> tip;
    for (const mesh::FaceId f : t.faces()) {
        if (t.group_names()[std::size_t(t.group(f))] != "tip") continue;
        const auto corners = t.corners(f);
        for (int k = 0; k < corners.size(); ++k) tip.insert(t.vertex(corners[k]).value);
    }
    double shortest = 1e300, longest = 0.0;
    for (const mesh::EdgeId e : t.edges()) {
        if (tip.contains(t.start(e).value) == tip.contains(t.end(e).value)) continue;
        const double length =
            (cage.points.row(t.start(e).value) - cage.points.row(t.end(e).value)).norm();
        shortest = std::min(shortest, length);
        longest = std::max(longest, length);
    }
    CHECK(longest > 20.0);
    // Points step back along chords, for half of the longest, and then go to the skin.
    CHECK(shortest > 0.45 * longest);
}

TEST_CASE("remeshing keeps features and is closed", "[layout]") {
    const cage::CageResult result =
        cage::make_cage(wing().reference, {.method = cage::Method::Remesh});
    const mesh::Topology& topology = *result.cage.topology;
    CHECK(result.method == cage::Method::Remesh);
    CHECK(topology.is_closed());
    CHECK(volume(result.cage) == Approx(121602975.0).epsilon(0.05));
    int creases = 0;
    for (const mesh::EdgeId e : topology.edges()) {
        if (topology.sharpness(e) == 0.0) continue;
        ++creases;
        for (const mesh::VertexId v : {topology.start(e), topology.end(e)}) {
            const auto foot = wing().reference.feature_point(
                result.cage.points.row(v.value).transpose(), geom::FeatureKind::Sharp);
            REQUIRE(foot);
            CHECK(foot->distance < 1e-6);
        }
    }
    CHECK(creases > 20);
    for (const mesh::FaceId f : topology.faces()) CHECK(topology.size(f) <= 4);
    for (const geom::FeatureCorner& corner : wing().reference.features().corners) {
        double nearest = 1e300;
        for (Eigen::Index i = 0; i < result.cage.points.rows(); ++i)
            nearest =
                std::min(nearest, (result.cage.points.row(i).transpose() - corner.point).norm());
        CHECK(nearest < 1e-6);
    }
}

TEST_CASE("the number of faces follows what is asked for", "[layout]") {
    for (const int target : {600, 1500}) {
        const cage::CageResult result = cage::make_cage(
            wing().reference, {.method = cage::Method::Remesh, .target_faces = target});
        // Lengths are scaled by the number of faces they gave until it is within a fifth or so.
        CHECK(result.cage.topology->face_count() > target / 1.3);
        CHECK(result.cage.topology->face_count() < 1.3 * target);
    }
}

/// A closed surface 200 long, 80 wide and 4 thick, rounded all around, smooth everywhere.
const Sample& lens() {
    static const Sample sample = [] {
        mesh::Cage cage = test::cube(2.0);
        cage.points = cage.points * Eigen::Vector3d(200.0, 80.0, 4.0).asDiagonal();
        occ::CadModel model = occ::assemble(patch::extract(cage).patches);
        occ::CadReference reference(model);
        return Sample{std::move(model), std::move(reference)};
    }();
    return sample;
}

TEST_CASE("thin rounded edges are not eaten by remeshing", "[layout]") {
    const cage::CageResult result =
        cage::make_cage(lens().reference, {.method = cage::Method::Remesh});
    CHECK(result.cage.topology->is_closed());
    // Every point of the model is near a face of the cage: as near as its chords are.
    const double diagonal = lens().reference.bounds().diagonal();
    const auto& t = *result.cage.topology;
    std::vector<geom::Vec3> points;
    for (const mesh::FaceId f : t.faces()) {
        const auto corners = t.corners(f);
        const auto at = [&](int k) {
            return geom::Vec3(
                result.cage.points.row(t.vertex(corners[std::min(k, corners.size() - 1)]).value));
        };
        constexpr int n = 8;
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j) {
                const double u = double(i) / n, v = double(j) / n;
                points.push_back((1 - u) * (1 - v) * at(0) + u * (1 - v) * at(1) + u * v * at(2) +
                                 (1 - u) * v * at(3));
            }
    }
    double worst = 0.0;
    for (const auto& sample : lens().reference.sample(500)) {
        double nearest = 1e300;
        for (const geom::Vec3& p : points) nearest = std::min(nearest, (p - sample.point).norm());
        worst = std::max(worst, nearest);
    }
    CHECK(worst < 0.03 * diagonal);
    CHECK(volume(result.cage) > 0.0);
}

TEST_CASE("edges are shorter where a cage is asked to be finer", "[layout]") {
    const geom::Vec3 tip = wing().reference.bounds().max;
    const double radius = 0.2 * wing().reference.bounds().diagonal();
    const auto near = [&](const cage::CageResult& made) {
        int count = 0;
        for (Eigen::Index i = 0; i < made.cage.points.rows(); ++i)
            count += (made.cage.points.row(i).transpose() - tip).norm() < radius ? 1 : 0;
        return count;
    };
    cage::CageOptions options{.method = cage::Method::Remesh};
    const auto usual = cage::make_cage(wing().reference, options);
    options.finer_at = {{.balls = {{tip, radius}}}};
    const auto finer = cage::make_cage(wing().reference, options);
    // Half the lengths are four times the vertices; features and growth of lengths take some away.
    CHECK(near(finer) > 2 * near(usual));
    const int elsewhere_usual = int(usual.cage.points.rows()) - near(usual);
    const int elsewhere_finer = int(finer.cage.points.rows()) - near(finer);
    CHECK(elsewhere_finer < 2 * elsewhere_usual);
    // Balls of one region that overlap count once.
    options.finer_at = {{.balls = {{tip, radius}, {tip, radius}}}};
    const auto twice = cage::make_cage(wing().reference, options);
    CHECK(twice.cage.points == finer.cage.points);
    // Factors of regions that overlap multiply, but for lengths that grow from their middles.
    options.finer_at = {{.balls = {{tip, radius}}}, {.balls = {{tip, radius}}}};
    const auto quarter = cage::make_cage(wing().reference, options);
    options.finer_at = {{.balls = {{tip, radius}}, .edge_length_factor = 0.25}};
    const auto at_once = cage::make_cage(wing().reference, options);
    CHECK(near(quarter) == Approx(near(at_once)).epsilon(0.1));
    CHECK(near(quarter) > 2 * near(finer));
}

/// A box that is laid out in blocks along its faces.
const Sample& box() {
    static const Sample sample = [] {
        mesh::TopologyInput tags;
        for (const auto& face : test::cube_faces)
            for (std::size_t k = 0; k < 4; ++k)
                if (face[k] < face[(k + 1) % 4])
                    tags.creases.push_back({face[k], face[(k + 1) % 4], mesh::infinite_sharpness});
        mesh::Cage cage = test::cube(2.0, tags);
        cage.points = cage.points * Eigen::Vector3d(60.0, 40.0, 20.0).asDiagonal();
        occ::CadModel model = occ::assemble(patch::extract(cage).patches);
        occ::CadReference reference(model);
        return Sample{std::move(model), std::move(reference)};
    }();
    return sample;
}

/// Makes a cage with a callback that refuses call number n.
/// @return the number of calls, none after the one that was refused
int calls_until(int n, const geom::ModelSurface& model, cage::Method method) {
    int calls = 0;
    bool in_range = true;
    const auto progress = [&](std::string_view, double fraction) {
        in_range = in_range && fraction >= 0.0 && fraction <= 1.0;
        return ++calls != n;
    };
    try {
        cage::make_cage(model, {.method = method, .progress = progress});
        CHECK(calls < n);
    } catch (const base::Cancelled&) {
        CHECK(calls == n);
    }
    CHECK(in_range);
    return calls;
}

TEST_CASE("progress stops layouts of wings, blocks and remeshing wherever they are", "[layout]") {
    const std::vector<std::pair<const Sample*, cage::Method>> cases{
        {&wing(), cage::Method::Aligned},
        {&box(), cage::Method::Aligned},
        {&box(), cage::Method::Remesh},
        {&wing(), cage::Method::Remesh}};
    for (const auto& [sample, method] : cases) {
        const int all = calls_until(std::numeric_limits<int>::max(), sample->reference, method);
        CHECK(all > 100);
        for (const int n : {1, 2, all / 4, all / 2, 3 * all / 4, all})
            CHECK(calls_until(n, sample->reference, method) == n);
    }
}

TEST_CASE("the number of a wing's faces follows too, by lines around and along", "[layout]") {
    for (const int target : {60, 400}) {
        const cage::CageResult result = cage::make_cage(wing().reference, {.target_faces = target});
        CHECK(result.method == cage::Method::Aligned);
        // Whole lines come and go.
        CHECK(result.cage.topology->face_count() > target / 1.5);
        CHECK(result.cage.topology->face_count() < 1.5 * target);
    }
}

TEST_CASE("the same model gives the same cage", "[layout]") {
    const cage::CageOptions options{.method = cage::Method::Remesh};
    const auto a = cage::make_cage(wing().reference, options);
    const auto b = cage::make_cage(wing().reference, options);
    REQUIRE(a.cage.points.rows() == b.cage.points.rows());
    CHECK(a.cage.points == b.cage.points);
}

TEST_CASE("options out of range are refused", "[layout]") {
    CHECK_THROWS_AS(cage::make_cage(wing().reference, {.fineness = 0.0}), base::InvalidArgument);
}

TEST_CASE("a triangulated wing gets the wing's layout", "[layout][mesh]") {
    const occ::CadReference& reference = wing().reference;
    const geom::SurfaceMesh surface = reference.surface_mesh(1e-4 * reference.bounds().diagonal());
    geom::TriangleMesh mesh{surface.points, surface.triangles, {}, {}};
    CHECK(geom::make_sound(mesh, "wing").closed_bodies == 1);
    const geom::MeshReference triangles(mesh);
    const auto made = cage::make_cage(triangles, {.tolerance_rel = 1e-3});
    const auto from_cad = cage::make_cage(reference, {.tolerance_rel = 1e-3});
    CHECK(made.method == cage::Method::Aligned);
    CHECK(made.cage.topology->face_count() == from_cad.cage.topology->face_count());
    CHECK(mesh::summarise(*made.cage.topology).creases ==
          mesh::summarise(*from_cad.cage.topology).creases);
}

}  // namespace
}  // namespace patchwright
