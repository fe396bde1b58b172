#include "fit/loop/facing.h"

#include "fit/loop/sampling.h"

#include <patchwright/base/parallel.h>

namespace patchwright::fit {

bool faces_away(const mesh::Cage& cage, const geom::ReferenceSurface& reference) {
    const subd::LimitOperator limit(*cage.topology, {interior_grid(2)}, face_sites(*cage.topology),
                                    subd::SampleRows::PointsAndTangents);
    Eigen::VectorXd agreement = Eigen::VectorXd::Zero(limit.rows());
    limit.visit_sites(cage.points, [&](std::size_t begin, std::size_t, auto at, auto normals) {
        const Eigen::Index row = limit.site_rows()[begin];
        base::parallel_for(std::size_t(at.rows()), 64, [&](std::size_t first, std::size_t last) {
            for (auto i = Eigen::Index(first); i < Eigen::Index(last); ++i) {
                const double cosine =
                    normals.row(i).dot(reference.foot_point(at.row(i).transpose()).normal);
                agreement[row + i] = cosine < 0.0 ? -normals.row(i).norm() : normals.row(i).norm();
            }
        });
    });
    return agreement.sum() < -0.5 * agreement.cwiseAbs().sum();
}

}  // namespace patchwright::fit
