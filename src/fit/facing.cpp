#include "fit/facing.h"

#include "fit/sampling.h"

#include <patchwright/base/parallel.h>

namespace patchwright::fit {

bool faces_away(const mesh::Cage& cage, const geom::ReferenceSurface& reference) {
    const subd::LimitOperator limit(*cage.topology, {interior_grid(2)}, face_sites(*cage.topology),
                                    subd::SampleRows::PointsAndTangents);
    geom::Points at;
    limit.apply(cage.points, at);
    const geom::Points normals = limit.normals(cage.points);
    Eigen::VectorXd agreement = Eigen::VectorXd::Zero(at.rows());
    base::parallel_for(std::size_t(at.rows()), 64, [&](std::size_t first, std::size_t last) {
        for (auto i = Eigen::Index(first); i < Eigen::Index(last); ++i) {
            const double cosine =
                normals.row(i).dot(reference.foot_point(at.row(i).transpose()).normal);
            agreement[i] = cosine < 0.0 ? -normals.row(i).norm() : normals.row(i).norm();
        }
    });
    return agreement.sum() < -0.5 * agreement.cwiseAbs().sum();
}

}  // namespace patchwright::fit
