#include "fit/bench_orders.h"

#include "fit/solve/limit_rows.h"
#include "support/analytic_references.h"
#include "support/analytic_wing.h"
#include "support/bench.h"
#include "support/cages.h"

#include <patchwright/base/parallel.h>
#include <patchwright/fit/fit.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/limit_operator.h>
#include <patchwright/subd/refine.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

namespace patchwright::bench {

using geom::Points;
using geom::Vec3;
using nlohmann::ordered_json;

namespace {

struct Distance {
    double rms = 0.0, max = 0.0;
};

/// A part of the reference that stays the same whatever the cage, and how fast distances there
/// should fall.
struct Region {
    const char* name;
    double expected_rms, expected_max;
    std::function<bool(const geom::FootPoint&)> holds = [](const geom::FootPoint&) { return true; };
};

/// Of the limit surface, at 6 x 6 parameters a face, borders included.
std::vector<Distance> distances_of(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                                   const std::vector<Region>& regions) {
    subd::ParameterSet set;
    for (int i = 0; i < 6; ++i) {
        for (int j = 0; j < 6; ++j) set.emplace_back(i / 5.0, j / 5.0);
    }
    std::vector<subd::Site> sites;
    for (const mesh::FaceId f : cage.topology->faces()) sites.push_back({f, 0, 0});
    const subd::LimitOperator limit(*cage.topology, {set}, sites,
                                    subd::SampleRows::PointsAndTangents);
    Points at;
    limit.apply(cage.points, at);
    const Points normals = limit.normals(cage.points);
    std::vector<geom::FootPoint> feet(std::size_t(at.rows()));
    base::parallel_for(feet.size(), 64, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            const Vec3 n = normals.row(Eigen::Index(i)).transpose();
            const auto side = n.norm() > 0 ? std::optional<Vec3>(n.normalized()) : std::nullopt;
            feet[i] = reference.foot_point(at.row(Eigen::Index(i)).transpose(), side);
        }
    });
    std::vector<Distance> result;
    for (const Region& region : regions) {
        Distance sum;
        int count = 0;
        for (const geom::FootPoint& foot : feet) {
            if (!region.holds(foot)) continue;
            sum.rms += foot.distance * foot.distance;
            sum.max = std::max(sum.max, foot.distance);
            ++count;
        }
        result.push_back({std::sqrt(sum.rms / std::max(count, 1)), sum.max});
    }
    return result;
}

Distance distance_of(const mesh::Cage& cage, const geom::ReferenceSurface& reference) {
    return distances_of(cage, reference, {{"whole", 0, 0}}).front();
}

ordered_json order_of(const char* shape, const geom::ReferenceSurface& reference,
                      const std::function<mesh::Cage(int)>& cage_of, int levels,
                      const std::vector<Region>& regions) {
    ordered_json result{{"shape", shape}};
    std::vector<std::vector<Distance>> distances;
    for (int k = 0; k < levels; ++k) {
        const mesh::Cage cage = cage_of(k);
        const auto fitted = fit::fit(cage, reference, {.tolerance_mm = 1e-13, .max_levels = 0});
        distances.push_back(distances_of(fitted.cage, reference, regions));
        result["levels"].push_back({{"vertices", cage.topology->vertex_count()},
                                    {"cgls_steps", fitted.levels.back().cgls_steps},
                                    {"projections", fitted.levels.back().projections},
                                    {"seconds", fitted.levels.back().seconds}});
    }
    for (std::size_t r = 0; r < regions.size(); ++r) {
        ordered_json entry{{"region", regions[r].name},
                           {"expected_rms", regions[r].expected_rms},
                           {"expected_max", regions[r].expected_max}};
        const auto order = [](double before, double after, int halvings) {
            return std::log2(before / after) / halvings;
        };
        for (std::size_t k = 0; k < distances.size(); ++k) {
            const Distance& now = distances[k][r];
            entry["rms"].push_back(now.rms);
            entry["max"].push_back(now.max);
            if (k == 0) continue;
            const Distance& before = distances[k - 1][r];
            entry["orders_rms"].push_back(order(before.rms, now.rms, 1));
            entry["orders_max"].push_back(order(before.max, now.max, 1));
        }
        // Coarse cages gain from samples that slide; the order is that of the last two halvings.
        const Distance &last = distances.back()[r], &before = distances[distances.size() - 3][r];
        entry["order_rms"] = order(before.rms, last.rms, 2);
        entry["order_max"] = order(before.max, last.max, 2);
        result["regions"].push_back(entry);
    }
    return result;
}

/// Limit points and where they belong: curves of the model for vertices on borders and sharp
/// edges, corners for those in which three end, the surface for everything else.
class Samples {
  public:
    /// @param inside  samples of each face; none: one at each vertex instead
    Samples(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
            const subd::ParameterSet& inside)
        : reference_(reference) {
        const mesh::Topology& t = *cage.topology;
        std::vector<int> sharp(std::size_t(t.vertex_count()), 0);
        for (const mesh::EdgeId e : t.edges()) {
            if (!std::isinf(t.sharpness(e))) continue;
            for (const mesh::VertexId v : {t.start(e), t.end(e)}) {
                sharp[v.index()] |= t.is_boundary(e) ? border : crease;
            }
        }
        std::vector<subd::Site> sites(std::size_t(t.vertex_count()));
        for (const mesh::FaceId f : t.faces()) {
            for (int i = 0; i < 4; ++i) sites[t.vertex(t.corners(f)[i]).index()] = {f, 0, i};
        }
        if (!inside.empty()) {
            const std::vector<subd::Site> vertices = std::move(sites);
            sites.clear();
            for (std::size_t v = 0; v < vertices.size(); ++v) {
                if (sharp[v] == 0) continue;
                sites.push_back(vertices[v]);
                kind_.push_back(sharp[v]);
            }
            for (const mesh::FaceId f : t.faces()) sites.push_back({f, 0, 4});
            kind_.resize(kind_.size() + std::size_t(t.face_count()) * inside.size(), 0);
        } else {
            kind_ = sharp;
        }
        const auto at = [](double u, double v) { return subd::ParameterSet{{u, v}}; };
        limit_ = std::make_unique<subd::LimitOperator>(
            t, std::vector<subd::ParameterSet>{at(0, 0), at(1, 0), at(1, 1), at(0, 1), inside},
            sites);
    }
    [[nodiscard]] const subd::LimitOperator& limit() const { return *limit_; }
    [[nodiscard]] Points targets(const Points& limits) const {
        Points result(limits.rows(), 3);
        base::parallel_for(kind_.size(), 64, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                const Vec3 q = limits.row(Eigen::Index(i)).transpose();
                result.row(Eigen::Index(i)) = target(q, kind_[i]).transpose();
            }
        });
        return result;
    }

  private:
    static constexpr int border = 1, crease = 2;

    [[nodiscard]] Vec3 target(const Vec3& q, int kind) const {
        const geom::Features& features = reference_.features();
        if (kind == 0) return reference_.foot_point(q).point;
        Vec3 best = q;
        double distance = INFINITY;
        const auto take = [&](const Vec3& p) {
            if ((p - q).norm() >= distance) return;
            distance = (p - q).norm();
            best = p;
        };
        for (const auto& corner : features.corners) {
            if (kind == (border | crease)) take(corner.point);
        }
        for (std::size_t c = 0; c < features.curves.size(); ++c) {
            const bool free = features.curves[c].kind == geom::FeatureKind::Free;
            if (kind == (free ? border : crease)) {
                take(reference_.nearest_on_curve(static_cast<int>(c), q).point);
            }
        }
        return best;
    }

    const geom::ReferenceSurface& reference_;
    std::unique_ptr<subd::LimitOperator> limit_;
    std::vector<int> kind_;
};

struct Timed {
    mesh::Cage cage;
    double foot_points = 0.0, rest = 0.0;
    [[nodiscard]] double seconds() const { return foot_points + rest; }
};

/// Control points from foot points of the vertices' limit points by local rules only. One step is
/// the cubic quasi-interpolant (-1, 8, -1)/6 in both directions where the cage is regular, 2 Q - L
/// Q anywhere; more steps are Jacobi's for interpolation.
Timed local_rules(mesh::Cage cage, const geom::ReferenceSurface& reference, int steps) {
    Timed result{std::move(cage)};
    Points& p = result.cage.points;
    Points at, target;
    const double all = test::seconds([&] {
        const Samples samples(result.cage, reference, {});
        for (int step = 0; step < steps; ++step) {
            samples.limit().apply(p, at);
            result.foot_points += test::seconds([&] { target = samples.targets(at); });
            if (step == 0) {
                samples.limit().apply(target, at);
                p = 2.0 * target - at;
            } else {
                p += target - at;
            }
        }
    });
    result.rest = all - result.foot_points;
    return result;
}

/// Control points from foot points of 2 x 2 samples a face, and of vertices on curves, by least
/// squares.
Timed least_squares(mesh::Cage cage, const geom::ReferenceSurface& reference, int projections) {
    Timed result{std::move(cage)};
    Points& p = result.cage.points;
    Points at, target;
    const double all = test::seconds([&] {
        const subd::ParameterSet inside{{0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}};
        const Samples samples(result.cage, reference, inside);
        for (int step = 0; step < projections; ++step) {
            samples.limit().apply(p, at);
            result.foot_points += test::seconds([&] { target = samples.targets(at); });
            p = fit::solve_cgls(fit::LimitRows(samples.limit()), target, p,
                                {.relative_residual = 1e-4})
                    .x;
        }
    });
    result.rest = all - result.foot_points;
    return result;
}

}  // namespace

ordered_json orders() {
    ordered_json result;
    // Bicubic splines: four. What lowers that, with its part of the area, whose root counts in the
    // mean square:
    // - Extraordinary vertices: curvature there is not that of the reference (Peters and Reif,
    //   Subdivision Surfaces, 2008, ch. 6 and 7). The square of the width, on its square of the
    //   area.
    // - Sharp edges and borders: the curve rules leave no second derivative across them, as natural
    //   splines; where the reference is curved across, the square again, on a strip as wide as
    //   faces. The wing is curved so at its trailing edge, not at root and tip.
    // - NACA's half thickness 0.2969 sqrt(x) - 0.126 x ...: as x(z) = (z / 0.2969)^2 + 2 * 0.126 /
    //   0.2969^4 |z|^3 ... the nose has a jump in its third derivative: the third power, on a
    //   strip.
    const auto from_corner = [](const geom::FootPoint& foot) {
        return (foot.point.cwiseAbs() - Vec3::Constant(std::sqrt(1.0 / 3.0))).norm();
    };
    result.push_back(order_of("sphere", test::Sphere(1.0),
                              [](int k) { return subd::refine(test::cube(2.0), k + 1); }, 5,
                              {{"whole", 3.0, 2.0},
                               {"0.3 and more from extraordinary vertices", 4.0, 4.0,
                                [&](const auto& foot) { return from_corner(foot) > 0.3; }}}));
    result.push_back(order_of("torus", test::Torus(3.0, 1.0),
                              [](int k) { return test::torus(12 << k, 8 << k, 3.0, 1.0); }, 4,
                              {{"whole", 4.0, 4.0}}));
    const auto between = [](double low, double high) {
        return [low, high](const geom::FootPoint& foot) {
            const double s = std::abs(foot.uv.x());  // root of the chord's share
            return s >= low && s <= high;
        };
    };
    result.push_back(
        order_of("NACA wing", test::NacaWing(),
                 [](int k) { return test::naca_wing_cage(16 << k, 2 << k); }, 5,
                 {{"whole", 2.5, 2.0},
                  {"before half of the chord", 3.5, 3.0, between(0.0, std::sqrt(0.5))},
                  {"10 to 50 % of the chord", 4.0, 4.0, between(std::sqrt(0.1), std::sqrt(0.5))}}));
    result.push_back(order_of(
        "wing with smooth nose, no curvature at its trailing edge",
        test::NacaWing(test::WingSection::Smooth),
        [](int k) { return test::naca_wing_cage(16 << k, 2 << k, test::WingSection::Smooth); }, 5,
        {{"whole", 4.0, 4.0}}));
    return result;
}

ordered_json quasi_interpolation() {
    const test::NacaWing wing;
    ordered_json result;
    for (int k = 0; k < 5; ++k) {
        const mesh::Cage cage = test::naca_wing_cage(16 << k, 2 << k);
        ordered_json entry{{"vertices", cage.topology->vertex_count()}};
        const auto add = [&](const char* name, const std::function<Timed()>& make) {
            Timed best = make();
            for (int run = 1; run < 2; ++run) {
                Timed again = make();
                if (again.seconds() < best.seconds()) best = std::move(again);
            }
            const Distance distance = distance_of(best.cage, wing);
            entry[name] = {{"seconds", best.seconds()},
                           {"of_them_foot_points", best.foot_points},
                           {"rms", distance.rms},
                           {"max", distance.max}};
        };
        add("quasi_interpolation", [&] { return local_rules(cage, wing, 1); });
        add("local_10_steps", [&] { return local_rules(cage, wing, 10); });
        add("least_squares", [&] { return least_squares(cage, wing, 1); });
        if (k < 4) {
            add("least_squares_10_projections", [&] { return least_squares(cage, wing, 10); });
        }
        result.push_back(entry);
    }
    return result;
}

}  // namespace patchwright::bench
