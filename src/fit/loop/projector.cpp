#include "fit/loop/projector.h"

#include "fit/loop/sampling.h"

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <cmath>

namespace patchwright::fit {

using geom::Points;
using geom::Vec3;

namespace {

// Sine of the angle between a residual and the normal of its foot point beyond which the foot
// point lies on a border or a sharp edge: the residual then counts in all directions.
constexpr double normality_threshold = 0.3;
// Shorter residuals, in parts of the tolerance, are too short to tell their direction from noise.
constexpr double min_directed_residual_rel = 0.1;
// Cosine of the angle between the way to a point of the reference and the normal of its nearest
// limit point below which that one is no foot point: the point lies beyond an open border.
constexpr double min_foot_cosine = 0.5;
// In sizes of a face: foot points that face as a fold of it does are accepted as far as that
// (decision 076).
constexpr double widest_fold = 4.0;
// Foot points between two polls: about 0.1 s of them.
constexpr std::size_t batch = std::size_t(1) << 16;

}  // namespace

Points curve_points(const mesh::Cage& cage, const CurveSampling& curves, int samples_per_edge) {
    Points limit;
    subd::LimitOperator(*cage.topology, side_sets(samples_per_edge), curves.sites)
        .apply(cage.points, limit);
    return limit;
}

FeatureMatch match_cage(const mesh::Cage& cage, const CurveSampling& curves,
                        const Points& curve_points, const geom::ReferenceSurface& reference,
                        const FitOptions& options) {
    return match_features(cage, curves, curve_points, options.solver.samples_per_edge, reference,
                          options.feature_reach_rel * reference.bounds().diagonal(),
                          [&] { base::report_progress(options.progress, "match", 0.0); });
}

Projector::Projector(const mesh::Cage& given, const geom::ReferenceSurface& reference,
                     const FitOptions& options, double foot_reach, std::function<void()> poll)
    : topology_(given.topology),
      reference_(reference),
      options_(options),
      poll_(std::move(poll)),
      curves_(curve_sites(*topology_)),
      given_curves_(curve_points(given, curves_, options.solver.samples_per_edge)),
      match_(match_cage(given, curves_, given_curves_, reference, options)),
      parts_(*topology_, curves_, match_, reference),
      vertices_(*topology_, curves_, match_, reference),
      surface_(*topology_, surface_sets(options.solver.samples_per_edge),
               vertices_.after_faces(face_sites(*topology_)), subd::SampleRows::PointsAndTangents),
      curve_(*topology_, curve_sets(options.solver.samples_per_edge),
             vertices_.after_curves(curves_.sites)),
      given_normals_(surface_.normals(given.points)) {
    surface_.apply(given.points, given_limit_);
    set_reach(foot_reach);
    set_parts();
    const int n = options.solver.samples_per_edge;
    for (std::size_t c = 0; c < curves_.chains.size(); ++c) {
        const FeaturePath& path = match_.paths[c];
        if (path.empty()) continue;
        const EdgeChain& chain = curves_.chains[c];
        alignments_.push_back(
            {PathAlignment(reference_, path, chain.closed, chain.sites.size() * std::size_t(n)),
             {}});
        for (const auto& [site, backwards] : chain.sites)
            for (int k = 0; k < n; ++k)
                alignments_.back().rows.push_back(curve_.site_rows()[std::size_t(site)] +
                                                  (backwards ? n - 1 - k : k));
    }
}

void Projector::set_reach(double most) {
    reach_.resize(given_limit_.rows());
    const auto& rows = surface_.site_rows();
    for (std::size_t site = 0; site + 1 < rows.size(); ++site) {
        const auto of_face = given_limit_.middleRows(rows[site], rows[site + 1] - rows[site]);
        const double size = (of_face.colwise().maxCoeff() - of_face.colwise().minCoeff()).norm();
        reach_.segment(rows[site], rows[site + 1] - rows[site])
            .setConstant(std::min(most, widest_fold * size));
    }
}

void Projector::set_parts() {
    const auto& rows = surface_.site_rows();
    const std::vector<subd::Site> sites = face_sites(*topology_);
    for (std::size_t site = 0; site < sites.size(); ++site)
        part_of_row_.resize(std::size_t(rows[site + 1]), parts_.part_of(sites[site].face));
}

template <class Body>
void Projector::in_batches(std::size_t count, std::size_t grain, const Body& body) const {
    for (std::size_t begin = 0; begin < count; begin += batch) {
        if (begin > 0) poll_();
        base::parallel_for(
            std::min(batch, count - begin), grain,
            [&](std::size_t first, std::size_t end) { body(begin + first, begin + end); });
    }
}

Projection Projector::project_curves(const Points& points) const {
    Projection p(curve_, points);
    p.of_curves = true;
    p.normals.resize(p.limit.rows(), 3);
    std::vector<geom::FeaturePoint> on_path(std::size_t(p.limit.rows()));
    in_batches(alignments_.size(), 1, [&](std::size_t first, std::size_t end) {
        for (std::size_t c = first; c < end; ++c) {
            geom::Polyline chain;
            for (const auto row : alignments_[c].rows)
                chain.emplace_back(p.limit.row(row).transpose());
            const auto targets = alignments_[c].alignment.targets(chain);
            for (std::size_t i = 0; i < targets.size(); ++i)
                on_path[std::size_t(alignments_[c].rows[i])] = targets[i];
        }
    });
    in_batches(curves_.sites.size(), 16, [&](std::size_t first, std::size_t end) {
        for (std::size_t site = first; site < end; ++site) project_curve_site(site, on_path, p);
    });
    vertices_.project(curve_, p);
    p.sum_up();
    return p;
}

void Projector::project_curve_site(std::size_t site, const std::vector<geom::FeaturePoint>& on_path,
                                   Projection& p) const {
    const auto& rows = curve_.site_rows();
    const FeaturePath& path = match_.paths[std::size_t(curves_.chain_of_site[site])];
    for (auto row = rows[site]; row < rows[site + 1]; ++row) {
        const Vec3 at = p.limit.row(row).transpose();
        const auto before = std::max(row - 1, rows[site]);
        const auto next = std::min(row + 1, rows[site + 1] - 1);
        const Eigen::RowVector3d given = given_curves_.row(next) - given_curves_.row(before);
        p.normals.row(row) = p.limit.row(next) - p.limit.row(before);
        p.jacobian_ratio[row] = p.normals.row(row).dot(given) / given.squaredNorm();
        if (path.empty()) {
            p.target.row(row) = reference_.foot_point(at).point.transpose();
        } else {
            const geom::FeaturePoint& feature = on_path[std::size_t(row)];
            p.target.row(row) = feature.point.transpose();
            set_direction(p, row, feature.tangent, false);
        }
    }
}

Projection Projector::project_surface(const Points& points, const Projection* last) const {
    Projection p(surface_, points);
    p.normals = surface_.normals(points);
    const auto on_faces = std::size_t(vertices_.rows_before(surface_, false));
    in_batches(on_faces, 64, [&](std::size_t first, std::size_t end) {
        for (auto i = Eigen::Index(first); i < Eigen::Index(end); ++i) {
            const auto normal = unit_or_none(p.normals.row(i).transpose());
            const geom::FootPoint foot =
                oriented_foot_point(reference_, p.limit.row(i).transpose(), normal, reach_[i],
                                    part_of_row_[std::size_t(i)]);
            p.target.row(i) = foot.point.transpose();
            p.jacobian_ratio[i] = p.normals.row(i).dot(foot.normal) / given_normals_.row(i).norm();
            set_direction(p, i, foot.normal, true);
            p.weights.weight[i] = sample_weight(p, last, i, normal ? foot.normal.dot(*normal) : 1.0,
                                                options_.tolerance_mm);
        }
    });
    add_reverse_targets(points, p);
    vertices_.project(surface_, p);
    p.sum_up();
    return p;
}

std::vector<measure::NearLimit> Projector::nearest(const Points& points,
                                                   const std::vector<Vec3>& queries) {
    if (!search_) search_.emplace(topology_);
    return search_->nearest(points, queries);
}

void Projector::add_reverse_targets(const Points& points, Projection& p) const {
    if (reverse_targets_.empty()) return;
    const int n = options_.solver.samples_per_edge;
    const std::vector<measure::NearLimit> near = search_->nearest(points, reverse_targets_);
    // A sample takes the farthest of the points that are nearest to it.
    std::vector<double> distance(std::size_t(p.limit.rows()),
                                 reverse_target_share * options_.tolerance_mm);
    for (std::size_t k = 0; k < near.size(); ++k) {
        const auto cell = [&](double t) { return std::min(int(t * n), n - 1); };
        const Eigen::Index i =
            surface_.site_rows()[std::size_t(near[k].site)] + cell(near[k].u) * n + cell(near[k].v);
        const Vec3 way = reverse_targets_[k] - near[k].point;
        const bool beyond_border =
            std::abs(way.dot(near[k].normal)) < min_foot_cosine * near[k].distance;
        if (beyond_border || !(near[k].distance > distance[std::size_t(i)])) continue;
        distance[std::size_t(i)] = near[k].distance;
        p.target.row(i) = p.limit.row(i) + way.transpose();
        p.weights.direction.row(i) = way.transpose() / near[k].distance;
        p.weights.weight[i] = 1.0;
    }
}

bool Projector::is_inverted_when_given(std::int32_t first, std::int32_t end) const {
    for (auto i = first; i < end; ++i) {
        const Vec3 normal = given_normals_.row(i).transpose();
        const Vec3 at = given_limit_.row(i).transpose();
        if (normal.dot(reference_.foot_point(at).normal) < 0.0) return true;
    }
    return false;
}

bool Projector::is_folded_when_given(std::int32_t first, std::int32_t end) const {
    const Eigen::RowVector3d mean = given_normals_.middleRows(first, end - first).colwise().sum();
    for (auto i = first; i < end; ++i)
        if (given_normals_.row(i).dot(mean) < 0.0) return true;
    return false;
}

void Projector::set_direction(Projection& p, Eigen::Index row, const Vec3& direction,
                              bool along) const {
    const Vec3 residual = (p.target.row(row) - p.limit.row(row)).transpose();
    const double length = residual.norm();
    const double cosine = std::abs(residual.dot(direction));
    const double off = along ? std::sqrt(std::max(0.0, length * length - cosine * cosine)) : cosine;
    if (off > normality_threshold * length &&
        length > min_directed_residual_rel * options_.tolerance_mm)
        return;
    p.weights.direction.row(row) = direction.transpose();
}

}  // namespace patchwright::fit
