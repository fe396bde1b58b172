#include "fit/stiffness.h"

#include "fit/level_fit.h"
#include "fit/sampling.h"

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace patchwright::fit {

using geom::Points;
using mesh::Topology;

namespace {

// What slides where the surface is about to fold counts so much more than before, and at most so
// much in all.
constexpr double stiffer = 10.0, stiffest = 1e4;

/// Of the evenness of each row: each in the widths of its face.
Eigen::VectorXd evenness_of(const Topology& topology, const Points& points, double slack) {
    std::vector<double> rows;
    rows.reserve(std::size_t(12) * std::size_t(topology.face_count()));
    std::vector<double> sides;
    for (const mesh::FaceId f : topology.faces()) {
        const int n = topology.size(f);
        sides.clear();
        for (const mesh::CornerId c : topology.corners(f)) {
            const auto a = topology.vertex(c), b = topology.vertex(topology.next(c));
            sides.push_back((points.row(a.value) - points.row(b.value)).norm());
        }
        for (int sector = 0; sector < (n == 4 ? 1 : n); ++sector) {
            const auto at = [&](int i) { return sides[std::size_t((sector + i) % n)]; };
            const double u = n == 4 ? 0.5 * (at(0) + at(2)) : 0.5 * at(0);
            const double v = n == 4 ? 0.5 * (at(1) + at(3)) : 0.5 * at(n - 1);
            for (int sample = 0; sample < 4; ++sample) {
                rows.insert(rows.end(), {u * u, u * v, v * v});
            }
        }
    }
    return Eigen::Map<const Eigen::VectorXd>(rows.data(), Eigen::Index(rows.size()))
               .cwiseMax(1e-300)
               .cwiseInverse() *
           std::pow(slack, 2);
}

/// The part across the directions; none where there is none.
Eigen::RowVector3d tangential(const Stiffness& s, const Eigen::RowVector3d& row, Eigen::Index i) {
    const Eigen::RowVector3d n = s.rows.direction.row(i);
    if (n.isZero()) return Eigen::RowVector3d::Zero();
    return row - row.dot(n) * n;
}

}  // namespace

SurfaceStiffness::SurfaceStiffness(const Topology& topology, const Points& given, double slack)
    : rows_(topology, {interior_grid(2)}, face_sites(topology), subd::SampleRows::Bending),
      places_(topology, {interior_grid(2)}, face_sites(topology),
              subd::SampleRows::PointsAndTangents),
      evenness_(evenness_of(topology, given, slack)),
      stiffened_(rows_.site_rows().size() - 1, 1.0) {
    rows_.apply(given, given_);
}

bool SurfaceStiffness::stiffen(const std::function<bool(std::size_t)>& folds) {
    bool any = false;
    const auto& rows = rows_.site_rows();
    for (std::size_t site = 0; site + 1 < rows.size(); ++site) {
        if (stiffened_[site] >= stiffest || !folds(site)) continue;
        stiffened_[site] *= stiffer;
        evenness_.segment(rows[site], rows[site + 1] - rows[site]) *= stiffer;
        any = true;
    }
    return any;
}

Stiffness SurfaceStiffness::around(const Points& points, double bending, double evenness) const {
    Stiffness s{.bending = bending, .evenness = evenness * evenness_};
    s.rows.along = std::sqrt(bending);
    s.rows.across_by_row = (s.evenness.array() + bending).sqrt();
    s.rows.without = s.rows.along;
    s.rows.direction.resize(rows_.rows(), 3);
    const auto& rows = rows_.site_rows();
    places_.visit_sites(points, [&](std::size_t begin, std::size_t, auto, auto normals) {
        for (Eigen::Index i = 0; i < normals.rows(); ++i) {
            const auto normal = unit_or_none(normals.row(i).transpose());
            s.rows.direction.middleRows(rows[begin] + 3 * i, 3).rowwise() =
                normal.value_or(geom::Vec3::Zero()).transpose();
        }
    });
    return s;
}

Points SurfaceStiffness::changes(const Points& points, const Stiffness& s) const {
    Points rows;
    rows_.apply(points, rows);
    base::parallel_for(std::size_t(rows.rows()), 4096, [&](std::size_t first, std::size_t last) {
        for (auto i = Eigen::Index(first); i < Eigen::Index(last); ++i) {
            const double both = s.bending + s.evenness[i];
            const double share = both > 0.0 ? s.evenness[i] / both : 0.0;
            rows.row(i) = share * tangential(s, given_.row(i), i) - rows.row(i);
        }
    });
    return rows;
}

double SurfaceStiffness::energy(const Points& points, const Stiffness& s) const {
    const auto& rows_of = rows_.site_rows();
    std::vector<double> of_site(rows_of.size() - 1, 0.0);
    rows_.visit_sites(points, [&](std::size_t begin, std::size_t end, auto rows, auto) {
        for (std::size_t site = begin; site < end; ++site) {
            for (auto i = rows_of[site]; i < rows_of[site + 1]; ++i) {
                const Eigen::RowVector3d now = rows.row(i - rows_of[begin]);
                of_site[site] +=
                    s.bending * now.squaredNorm() +
                    s.evenness[i] * tangential(s, now - given_.row(i), i).squaredNorm();
            }
        }
    });
    return std::accumulate(of_site.begin(), of_site.end(), 0.0);
}

}  // namespace patchwright::fit
