#include "measure/limit_folds.h"

#include "measure/limit_sites.h"
#include "measure/near_curves.h"
#include "measure/normal_agreement.h"

#include <patchwright/base/parallel.h>
#include <patchwright/measure/verdict.h>
#include <patchwright/subd/limit_operator.h>

#include <array>

namespace patchwright::measure {

namespace {

// Samples along each side of a face, and of the squares in its corners.
constexpr int samples_a_side = 4;
// Sides of these squares, of the face's: folds at corners of the model are smaller than faces.
constexpr std::array corner_squares{0.25, 0.0625};

subd::ParameterSet fold_grid() {
    subd::ParameterSet grid = interior_grid(samples_a_side);
    const subd::ParameterSet whole = grid;
    for (const double size : corner_squares)
        for (const Eigen::Vector2d& p : whole)
            for (const double u : {size * p.x(), 1.0 - size * p.x()})
                for (const double v : {size * p.y(), 1.0 - size * p.y()}) grid.emplace_back(u, v);
    return grid;
}

}  // namespace

std::vector<int> folded_samples(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                                double tolerance_mm) {
    const auto sites = face_sites(*cage.topology);
    const subd::LimitOperator samples(*cage.topology, {fold_grid()}, sites,
                                      subd::SampleRows::PointsAndTangents);
    geom::Points points;
    samples.apply(cage.points, points);
    const geom::Points normals = samples.normals(cage.points);
    const NormalAgreement agreement(reference, tolerance_mm, fold_limit_rad);
    const NearCurves edges(reference, {}, tolerance_mm);
    std::vector<int> of_site(sites.size(), 0);
    base::parallel_for(sites.size(), 8, [&](std::size_t first, std::size_t last) {
        for (std::size_t s = first; s < last; ++s) {
            for (auto i = samples.site_rows()[s]; i < samples.site_rows()[s + 1]; ++i) {
                const geom::Vec3 point = points.row(i).transpose();
                const geom::Vec3 normal = normals.row(i).transpose().normalized();
                if (normal.isZero() || agreement.angle_at_foot(point, normal) <= fold_limit_rad)
                    continue;
                if (!edges.is_near(point) && agreement.least_angle(point, normal) > fold_limit_rad)
                    ++of_site[s];
            }
        }
    });
    std::vector<int> of_face(std::size_t(cage.topology->face_count()), 0);
    for (std::size_t s = 0; s < sites.size(); ++s) of_face[sites[s].face.index()] += of_site[s];
    return of_face;
}

}  // namespace patchwright::measure
