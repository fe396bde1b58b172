#include "subd/opensubdiv_oracle.h"
#include "support/cages.h"

#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>
#include <opensubdiv/far/primvarRefiner.h>

using namespace patchwright;

namespace {

namespace Far = OpenSubdiv::Far;

struct OsdPoint {
    geom::Vec3 p = geom::Vec3::Zero();
    void Clear(void* = nullptr) { p.setZero(); }
    void AddWithWeight(const OsdPoint& other, double weight) { p += weight * other.p; }
};

/// The largest distance between our refined points and OpenSubdiv's over `levels` steps; vertices
/// are matched by the coarse vertex, edge or face they come from.
double difference_to_osd(const mesh::Cage& cage, int levels) {
    const auto refiner = test::osd_refiner(*cage.topology);
    refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(levels));
    mesh::Cage ours = cage;
    std::vector<OsdPoint> theirs(std::size_t(cage.points.rows()));
    std::vector<int> theirs_of(theirs.size());  // our vertex -> theirs
    for (std::size_t v = 0; v < theirs.size(); ++v) {
        theirs[v].p = cage.points.row(Eigen::Index(v)).transpose();
        theirs_of[v] = int(v);
    }
    double worst = 0.0;
    const Far::PrimvarRefinerReal<double> primvars(*refiner);
    for (int level = 1; level <= levels; ++level) {
        const Far::TopologyLevel& coarse = refiner->GetLevel(level - 1);
        std::vector<OsdPoint> fine(std::size_t(refiner->GetLevel(level).GetNumVertices()));
        primvars.Interpolate(level, theirs, fine);
        const mesh::Topology& t = *ours.topology;
        std::vector<int> fine_of;
        for (const mesh::VertexId v : t.vertices()) {
            fine_of.push_back(coarse.GetVertexChildVertex(theirs_of[v.index()]));
        }
        for (const mesh::EdgeId e : t.edges()) {
            const int edge =
                coarse.FindEdge(theirs_of[t.start(e).index()], theirs_of[t.end(e).index()]);
            fine_of.push_back(coarse.GetEdgeChildVertex(edge));
        }
        for (const mesh::FaceId f : t.faces()) {
            // The one face of theirs that has all vertices of ours.
            int found = -1;
            for (const int candidate :
                 coarse.GetVertexFaces(theirs_of[t.vertex(t.corners(f)[0]).index()])) {
                const auto vertices = coarse.GetFaceVertices(candidate);
                bool all = vertices.size() == t.size(f);
                for (const mesh::CornerId c : t.corners(f)) {
                    all = all && vertices.FindIndex(theirs_of[t.vertex(c).index()]) >= 0;
                }
                if (all) found = candidate;
            }
            fine_of.push_back(coarse.GetFaceChildVertex(found));
        }
        ours = subd::refine(ours, 1);
        for (std::size_t v = 0; v < fine_of.size(); ++v) {
            const geom::Vec3 p = ours.points.row(Eigen::Index(v)).transpose();
            worst = std::max(worst, (p - fine[std::size_t(fine_of[v])].p).norm());
        }
        theirs = std::move(fine);
        theirs_of = std::move(fine_of);
    }
    return worst;
}

}  // namespace

TEST_CASE("refined points are OpenSubdiv's, whatever the features", "[subd][oracle]") {
    // Sharpness is a float there: fractional tags differ by up to 1e-7 of a blend.
    for (unsigned seed = 0; seed < 60; ++seed) {
        CAPTURE(seed);
        const bool semi_sharp = seed % 3 == 2;
        const mesh::Cage cage =
            test::random_cage(seed, {.open = seed % 2 == 1,
                                     .crease_share = 0.1 * (seed % 5),
                                     .semi_sharp = semi_sharp,
                                     .rule = seed % 4 < 2 ? mesh::BoundaryRule::EdgeOnly
                                                          : mesh::BoundaryRule::EdgeAndCorner});
        CHECK(difference_to_osd(cage, 3) < (semi_sharp ? 3e-7 : 1e-14 * 50));
    }
}

TEST_CASE("subdivision matrices have rows of sum 1 and refine linearly", "[subd]") {
    for (unsigned seed = 0; seed < 10; ++seed) {
        const mesh::Cage cage =
            test::random_cage(seed, {.open = seed % 2 == 0, .semi_sharp = true});
        const subd::Refinement step = subd::refine(*cage.topology);
        CHECK(step.topology->all_quads());
        const geom::Points ones = geom::Points::Ones(cage.points.rows(), 3);
        CHECK((step.stencils.apply(ones).array() - 1.0).abs().maxCoeff() < 1e-14);
    }
}

TEST_CASE("group names and pins reach the refined mesh", "[subd]") {
    mesh::TopologyInput tags;
    tags.face_group = {0, 0, 1, 1, 1, 1};
    tags.group_names = {"ends", "sides"};
    tags.pins = {3};
    const mesh::Cage fine = subd::refine(test::cube(1.0, tags), 1);
    CHECK(fine.topology->group(mesh::FaceId{7}) == 0);
    CHECK(fine.topology->group(mesh::FaceId{8}) == 1);
    CHECK(fine.topology->is_pinned(mesh::VertexId{3}));
}
