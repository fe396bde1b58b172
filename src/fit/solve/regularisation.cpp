#include "fit/solve/regularisation.h"

#include "fit/loop/level_fit.h"
#include "fit/loop/sampling.h"

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace patchwright::fit {

using geom::Points;
using mesh::Topology;

namespace {

/// Tangential weight of each row: second derivatives in units of the face's widths. Faces that have
/// collapsed count as wide as the scale: else nothing weighs beside them.
Eigen::VectorXd tangential_weights(const Topology& topology, const Points& points, double scale) {
    std::vector<double> rows;

    rows.reserve(std::size_t(12) * std::size_t(topology.face_count()));
    std::vector<double> sides;
    for (const mesh::FaceId f : topology.faces()) {
        const int n = topology.size(f);
        sides.clear();
        for (const mesh::CornerId c : topology.corners(f)) {
            const auto a = topology.vertex(c), b = topology.vertex(topology.next(c));
            sides.push_back(std::max((points.row(a.value) - points.row(b.value)).norm(), scale));
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
    const Eigen::Map<const Eigen::VectorXd> widths(rows.data(), Eigen::Index(rows.size()));
    if (scale == 0.0) return Eigen::VectorXd::Zero(widths.size());
    return std::pow(scale, 2) * widths.cwiseInverse();
}

/// The same of sides: only second derivatives along them count.
Eigen::VectorXd tangential_weights(const std::vector<subd::Site>& sides,
                                   const std::vector<std::int32_t>& site_rows,
                                   const subd::LimitOperator& ends, const Points& points,
                                   double scale) {
    Points limit;
    ends.apply(points, limit);
    Eigen::VectorXd tangential = Eigen::VectorXd::Zero(site_rows.back());
    for (std::size_t site = 0; site < sides.size(); ++site) {
        const auto at = ends.site_rows()[site];
        const double length = (limit.row(at + 1) - limit.row(at)).norm() +
                              (limit.row(at + 2) - limit.row(at + 1)).norm();
        const int along = sides[site].set % 2 == 0 ? 0 : 2;  // uu or vv
        for (auto row = site_rows[site]; row < site_rows[site + 1]; row += 3)
            tangential[row + along] =
                scale > 0.0 ? std::pow(scale / std::max(length, scale), 2) : 0.0;
    }
    return tangential;
}

}  // namespace

Regularisation::Regularisation(subd::LimitOperator rows, subd::LimitOperator positions,
                               const Points& given, Eigen::VectorXd tangential, double scale,
                               bool of_curves, bool evens_lines)
    : rows_(std::move(rows)),
      positions_(std::move(positions)),
      tangential_(std::move(tangential)),
      scale_(scale),
      factors_(rows_.site_rows().size() - 1, 1.0),
      of_curves_(of_curves),
      evens_lines_(evens_lines || scale == 0.0) {
    rows_.apply(given, given_);
}

Regularisation Regularisation::of_surface(const Topology& topology, const Points& given,
                                          double scale, bool evens_lines) {
    const auto sites = face_sites(topology);
    return {subd::LimitOperator(topology, {interior_grid(2)}, sites, subd::SampleRows::Bending),
            subd::LimitOperator(topology, {interior_grid(2)}, sites,
                                subd::SampleRows::PointsAndTangents),
            given,
            tangential_weights(topology, given, scale),
            scale,
            false,
            evens_lines};
}

Regularisation Regularisation::of_curves(const Topology& topology,
                                         const std::vector<subd::Site>& sites, const Points& given,
                                         double scale) {
    subd::LimitOperator rows(topology, side_sets(2), sites, subd::SampleRows::Bending);
    subd::LimitOperator positions(topology, closed_side_sets(2), sites);
    Eigen::VectorXd tangential =
        tangential_weights(sites, rows.site_rows(), positions, given, scale);
    return {
        std::move(rows), std::move(positions), given, std::move(tangential), scale, true, false};
}

void Regularisation::even_out(std::size_t site, double scale) {
    const auto& rows = rows_.site_rows();
    given_.middleRows(rows[site], rows[site + 1] - rows[site]).setZero();
    if (scale > scale_ && scale_ > 0.0) factors_[site] = std::pow(scale / scale_, 2);
}

Points Regularisation::directions(const Points& points) const {
    Points result(rows_.rows(), 3);
    const auto& rows = rows_.site_rows();
    positions_.visit_sites(points, [&](std::size_t begin, std::size_t end, auto ends,
                                       auto normals) {
        if (!of_curves_) {
            for (Eigen::Index i = 0; i < normals.rows(); ++i) {
                const auto normal = unit_or_none(normals.row(i).transpose());
                result.middleRows(rows[begin] + 3 * i, 3).rowwise() =
                    normal.value_or(geom::Vec3::Zero()).transpose();
            }
            return;
        }
        for (std::size_t site = begin; site < end; ++site) {
            const auto first = Eigen::Index(3 * (site - begin));
            for (int half = 0; half < 2; ++half) {
                const auto tangent =
                    unit_or_none((ends.row(first + half + 1) - ends.row(first + half)).transpose());
                result.middleRows(rows[site] + 3 * half, 3).rowwise() =
                    tangent.value_or(geom::Vec3::Zero()).transpose();
            }
        }
    });
    return result;
}

RegularisationWeights Regularisation::weights_at(const Points& points, double bending,
                                                 double tangential) const {
    RegularisationWeights s{.bending = of_curves_ ? 0.0 : bending,
                            .tangential = tangential * tangential_};
    const auto& rows = rows_.site_rows();
    for (std::size_t site = 0; site < factors_.size(); ++site)
        s.tangential.segment(rows[site], rows[site + 1] - rows[site]) *= factors_[site];
    s.rows.direction = directions(points);
    s.kept = Eigen::VectorXd::Ones(s.tangential.size());
    if (evens_lines_ && bending > 0.0)
        s.kept = s.tangential.array() / (s.tangential.array() + bending);
    if (of_curves_) {
        s.rows.weight = s.tangential.cwiseSqrt();
        s.rows.across = s.rows.without = 0.0;
        return s;
    }
    s.rows.along = std::sqrt(bending);
    s.rows.across_by_row = (s.tangential.array() + bending).sqrt();
    s.rows.without = s.rows.along;
    return s;
}

Eigen::RowVector3d Regularisation::tangential_part(const RegularisationWeights& s,
                                                   const Eigen::RowVector3d& row,
                                                   Eigen::Index i) const {
    const Eigen::RowVector3d n = s.rows.direction.row(i);
    if (n.isZero()) return Eigen::RowVector3d::Zero();
    const Eigen::RowVector3d along = row.dot(n) * n;
    return of_curves_ ? along : row - along;
}

Points Regularisation::changes(const Points& points, const RegularisationWeights& s) const {
    Points rows;
    rows_.apply(points, rows);
    base::parallel_for(std::size_t(rows.rows()), 4096, [&](std::size_t first, std::size_t last) {
        for (auto i = Eigen::Index(first); i < Eigen::Index(last); ++i) {
            rows.row(i) = s.kept[i] * tangential_part(s, given_.row(i), i) - rows.row(i);
        }
    });
    return rows;
}

double Regularisation::energy(const Points& points, const RegularisationWeights& s) const {
    const auto& rows_of = rows_.site_rows();
    std::vector<double> of_site(rows_of.size() - 1, 0.0);
    rows_.visit_sites(points, [&](std::size_t begin, std::size_t end, auto rows, auto) {
        for (std::size_t site = begin; site < end; ++site) {
            for (auto i = rows_of[site]; i < rows_of[site + 1]; ++i) {
                const Eigen::RowVector3d change =
                    rows.row(i - rows_of[begin]) - s.kept[i] * tangential_part(s, given_.row(i), i);
                const Eigen::RowVector3d sliding = tangential_part(s, change, i);
                of_site[site] +=
                    s.bending * change.squaredNorm() + s.tangential[i] * sliding.squaredNorm();
            }
        }
    });
    return std::accumulate(of_site.begin(), of_site.end(), 0.0);
}

}  // namespace patchwright::fit
