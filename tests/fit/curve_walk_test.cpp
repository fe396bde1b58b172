#include "fit/match/curve_walk.h"

#include "support/analytic_references.h"

#include <patchwright/geom/curve_ends.h>

#include <catch2/catch.hpp>

using namespace patchwright;
using geom::Vec3;

namespace {

/// Two straight curves of the same length that end in the origin, which is no corner.
class Bend final : public test::StraightEdged {
  public:
    explicit Bend(double length) {
        for (const Vec3& start : {Vec3(-length, 0, 0), Vec3(0, length, 0)}) {
            geom::FeatureCurve curve;
            curve.kind = geom::FeatureKind::Sharp;
            curve.length = length;
            curve.start = start;
            features_.curves.push_back(curve);
        }
    }
    geom::Box3 bounds() const override {
        return {features_.curves[0].start, features_.curves[1].start};
    }
    geom::FootPoint foot_point(const Vec3& q, const std::optional<Vec3>&) const override {
        return {q, Vec3::UnitZ(), 0.0, 0};
    }
};

}  // namespace

TEST_CASE("a walk ends where curves of any length and number of steps meet", "[fit][features]") {
    // For some of them length * count / count is less than the length.
    for (const double length : {0.7, 1.1, 51.63576, 72.9, 123.4}) {
        const Bend bend(length);
        const geom::CurveEnds ends = geom::curve_ends(bend.features(), 1e-6);
        for (int count = 2; count <= 60; ++count) {
            geom::Polyline chain;
            for (int k = count; k >= 0; --k) chain.emplace_back(-length * k / count, 0.01, 0.0);
            fit::CurveWalk walk(bend, ends,
                                {.kind = geom::FeatureKind::Sharp,
                                 .length_cost_mm = 1e-3,
                                 .coincidence_mm = 1e-6,
                                 .reach_mm = 1.0},
                                chain);
            const fit::FeaturePath path =
                walk.between({fit::Stop{-1, bend.features().curves[0].start, true},
                              fit::Stop{-1, Vec3::Zero(), true}});
            REQUIRE(path.size() == 1);
            CHECK(path[0].curve == 0);
            CHECK(path[0].range.from == 0.0);
            CHECK(path[0].range.to == length);
            CHECK(walk.mean_distance() == Approx(0.01));
        }
    }
}
