#include "geom/angle.h"
#include "measure/near_curves.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/measure/folds.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::measure {

using geom::Vec3;

namespace {

/// Of one direction: those that are not empty.
std::vector<std::array<double, 2>> knot_spans(const std::vector<double>& knots) {
    std::vector<std::array<double, 2>> spans;
    for (std::size_t k = 3; k + 4 < knots.size(); ++k)
        if (knots[k] < knots[k + 1]) spans.push_back({knots[k], knots[k + 1]});
    return spans;
}

/// Looks for points of the input that face the way a sample does.
class Agreement {
  public:
    Agreement(const geom::ReferenceSurface& input, const FoldOptions& options)
        : input_(input), options_(options) {}

    /// Least angle to the input's normals near the sample; ends early at one that agrees.
    [[nodiscard]] double least_angle(const Vec3& point, const Vec3& normal, double sign) const {
        const geom::FootPoint plain = input_.foot_point(point);
        const double reach = plain.distance + 2.0 * options_.tolerance_mm;
        const Vec3 side = sign * normal;
        double least = M_PI;
        const auto agrees = [&](const geom::FootPoint& foot) {
            if (!foot.normal.isZero() && (foot.point - point).norm() <= reach)
                least = std::min(least, geom::angle_between(foot.normal, side));
            return least <= options_.angle_rad;
        };
        if (agrees(plain) || agrees(input_.foot_point(point, side))) return least;
        // Of a displaced point the foot may be on another face of an edge or a tight bend; it is
        // within reach by the triangle inequality.
        const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
        for (const Vec3& way :
             std::array<Vec3, 10>{normal, Vec3(-normal), u, Vec3(-u), v, Vec3(-v),
                                  Vec3((u + v) * M_SQRT1_2), Vec3((u - v) * M_SQRT1_2),
                                  Vec3((v - u) * M_SQRT1_2), Vec3((u + v) * -M_SQRT1_2)}) {
            const Vec3 probe = point + options_.tolerance_mm * way;
            if (agrees(input_.foot_point(probe, side)) || agrees(input_.foot_point(probe)))
                return least;
        }
        return least;
    }

  private:
    const geom::ReferenceSurface& input_;
    const FoldOptions& options_;
};

/// Cosines between the samples' normals and those at their feet; 0 where one of them has none.
std::vector<double> cosines(const std::vector<geom::SurfaceSample>& samples,
                            const geom::ReferenceSurface& input, const base::Progress& progress) {
    std::vector<double> result(samples.size());
    constexpr std::size_t block = 8192, grain = 128;
    for (std::size_t start = 0; start < samples.size(); start += block) {
        base::report_progress(progress, "folds", double(start) / double(samples.size()));
        base::parallel_for(std::min(block, samples.size() - start), grain,
                           [&](std::size_t begin, std::size_t end) {
                               for (std::size_t i = start + begin; i < start + end; ++i) {
                                   const geom::SurfaceSample& s = samples[i];
                                   if (s.normal.isZero()) continue;
                                   result[i] = input.foot_point(s.point).normal.dot(s.normal);
                               }
                           });
    }
    return result;
}

}  // namespace

std::vector<geom::SurfaceSample> sample_surfaces(const std::vector<geom::BsplineSurface>& surfaces,
                                                 const SurfaceSampling& options) {
    if (options.per_span < 1 || options.at_most < 1)
        throw base::InvalidArgument("sample_surfaces: per_span and at_most must be positive");
    std::size_t spans = 0;
    for (const auto& s : surfaces)
        spans += knot_spans(s.knots_u).size() * knot_spans(s.knots_v).size();
    const auto limit = std::size_t(options.at_most);
    auto side = std::size_t(options.per_span);
    while (side > 1 && spans * side * side > limit) --side;
    const std::size_t step =
        (spans * side * side + limit - 1) / limit;  // spans that one stands for
    std::vector<geom::SurfaceSample> samples;
    samples.reserve(std::min(limit, spans * side * side));
    std::size_t number = 0;
    for (std::size_t k = 0; k < surfaces.size(); ++k) {
        const auto us = knot_spans(surfaces[k].knots_u), vs = knot_spans(surfaces[k].knots_v);
        for (const auto& [u0, u1] : us) {
            for (const auto& [v0, v1] : vs) {
                if (number++ % step != 0) continue;
                const double area = (u1 - u0) * (v1 - v0) * double(step) / double(side * side);
                for (std::size_t i = 0; i < side * side; ++i) {
                    const double s = (double(i / side) + 0.5) / double(side);
                    const double t = (double(i % side) + 0.5) / double(side);
                    const auto e = surfaces[k].at(u0 + s * (u1 - u0), v0 + t * (v1 - v0));
                    const Vec3 n = e.du.cross(e.dv);
                    const double size = n.norm();
                    const bool flat = !(size > 1e-12 * e.du.norm() * e.dv.norm());
                    samples.push_back({e.position, flat ? Vec3(Vec3::Zero()) : Vec3(n / size),
                                       int(k), size * area});
                }
            }
        }
    }
    return samples;
}

FoldFigures find_folds(const std::vector<geom::SurfaceSample>& samples,
                       const geom::ReferenceSurface& input, const FoldOptions& options) {
    if (!(options.tolerance_mm > 0.0) || !(options.angle_rad > 0.0))
        throw base::InvalidArgument("find_folds: the tolerance and the angle must be positive");
    const std::vector<double> cosine = cosines(samples, input, options.progress);
    double towards = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i)
        towards += samples[i].weight * (cosine[i] > 0.0 ? 1.0 : cosine[i] < 0.0 ? -1.0 : 0.0);
    const double sign = options.may_face_away && towards < 0.0 ? -1.0 : 1.0;

    FoldFigures figures;
    std::vector<std::size_t> doubtful;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (samples[i].normal.isZero()) continue;
        ++figures.samples;
        if (!(sign * cosine[i] >= std::cos(options.angle_rad))) doubtful.push_back(i);
    }
    if (doubtful.empty()) return figures;
    const Agreement agreement(input, options);
    const NearCurves edges(input, options.creases, options.tolerance_mm);
    std::vector<double> angle(doubtful.size());
    constexpr std::size_t grain = 16, block = 1024;
    for (std::size_t start = 0; start < doubtful.size(); start += block) {
        base::report_progress(options.progress, "folds", double(start) / double(doubtful.size()));
        base::parallel_for(std::min(block, doubtful.size() - start), grain,
                           [&](std::size_t begin, std::size_t end) {
                               for (std::size_t k = start + begin; k < start + end; ++k) {
                                   const geom::SurfaceSample& s = samples[doubtful[k]];
                                   if (edges.is_near(s.point)) continue;
                                   const double least =
                                       agreement.least_angle(s.point, s.normal, sign);
                                   if (least > options.angle_rad) angle[k] = least;
                               }
                           });
    }
    for (std::size_t k = 0; k < doubtful.size(); ++k) {
        if (!(angle[k] > 0.0)) continue;
        ++figures.folded;
        const geom::SurfaceSample& s = samples[doubtful[k]];
        if (!figures.worst || angle[k] > figures.worst->angle_rad)
            figures.worst = Fold{s.point, s.face, angle[k]};
    }
    return figures;
}

}  // namespace patchwright::measure
