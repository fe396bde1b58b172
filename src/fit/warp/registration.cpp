#include "fit/warp/registration.h"

#include "fit/loop/projector.h"
#include "fit/warp/lattice.h"

#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_mask.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

namespace patchwright::fit {

namespace {

using geom::Points;
using geom::Vec3;
using Matrix3 = Eigen::Matrix3d;

/// Sites of the surface at most: a lattice of a few hundred nodes needs no more.
constexpr std::size_t most_sites = 2048;
constexpr int samples_along = 2;  // of a face, in either direction
/// Chains and corners belong to features within this share of the diagonal: a span that grows by a
/// fifth moves the tip by that much.
constexpr double reach_rel = 0.25;
/// Weight of what is tangential to a surface or a curve: damps without holding back.
constexpr double tangential_weight = 0.01;
/// Weight of the stiffness in a stage's first step, its factor from step to step, and its least
/// one: distances of a thousandth of the bend are left to the fit.
constexpr double first_stiffness = 1e-2, stiffness_factor = 0.1, least_stiffness = 1e-6;
/// Steps of one stage at most, and the share of the distance that one has to leave behind.
constexpr int max_steps = 8;
constexpr double little_gain = 0.8;
/// Nodes of a lattice at most: its matrix is dense, and a step with so many takes half a second.
constexpr int most_nodes = 700;
/// Cells of the coarsest lattice.
constexpr int coarsest = 2;
/// Of the tolerance: a root mean square that leaves nothing to carry.
constexpr double near_share = 0.5;

/// Where the samples of a cage belong.
struct Ties {
    Points at, target;
    std::vector<Matrix3> metric;  ///< weight by direction; zero for samples that belong nowhere
    double rms = 0.0, max = 0.0;

    explicit Ties(Eigen::Index rows)
        : at(rows, 3), target(Points::Zero(rows, 3)), metric(std::size_t(rows), Matrix3::Zero()) {}
    void sum_up() {
        double squares = 0.0;
        Eigen::Index count = 0;
        for (Eigen::Index i = 0; i < at.rows(); ++i) {
            if (metric[std::size_t(i)].isZero(0.0)) continue;
            const double distance = (target.row(i) - at.row(i)).norm();
            squares += distance * distance;
            max = std::max(max, distance);
            ++count;
        }
        rms = count > 0 ? std::sqrt(squares / double(count)) : 0.0;
    }
};

/// Across a direction, or along it, and little of the rest.
Matrix3 metric_of(const Vec3& direction, bool along) {
    const Matrix3 projection = direction * direction.transpose();
    const Matrix3 most = along ? projection : Matrix3(Matrix3::Identity() - projection);
    return most + tangential_weight * (Matrix3::Identity() - most);
}

std::vector<subd::Site> some_face_sites(const mesh::Topology& topology) {
    const std::vector<subd::Site> all = face_sites(topology);
    const std::size_t step = (all.size() + most_sites - 1) / most_sites;
    std::vector<subd::Site> some;
    for (std::size_t i = 0; i < all.size(); i += std::max<std::size_t>(step, 1))
        some.push_back(all[i]);
    return some;
}

Points limit_positions(const mesh::Cage& cage) {
    Points limits(cage.points.rows(), 3);
    const subd::LimitEvaluator limit(cage.topology);
    for (const mesh::VertexId v : cage.topology->vertices())
        limits.row(v.value) = limit.position(cage.points, v).transpose();
    return limits;
}

/// Points at the same shares of a path's length as those of the chain have of its own. A closed
/// chain begins where the differences from the path vary least.
class ShareOfPath {
  public:
    ShareOfPath(const geom::ReferenceSurface& reference, const FeaturePath& path)
        : reference_(reference), path_(path) {
        for (const FeaturePiece& piece : path)
            start_.push_back(start_.back() + piece.range.to - piece.range.from);
    }

    [[nodiscard]] std::vector<Vec3> targets(const geom::Polyline& line, bool closed) const {
        std::vector<double> arcs = geom::arc_lengths(line);
        // The first and the last sample are half a step from the ends of the chain.
        const double ends =
            0.5 * ((line[1] - line[0]).norm() + (line.back() - line[line.size() - 2]).norm());
        const double first = 0.5 * (line[1] - line[0]).norm(), whole = arcs.back() + ends;
        for (double& arc : arcs) arc = (arc + first) / whole;
        if (!closed) return at(arcs, 0.0);
        std::array<double, phases> spread{};
        for (std::size_t k = 0; k < phases; ++k)
            spread[k] = spread_of(line, at(arcs, double(k) / phases));
        const auto best =
            std::size_t(std::min_element(spread.begin(), spread.end()) - spread.begin());
        // The vertex of the parabola through the least one and its neighbours.
        const double before = spread[(best + phases - 1) % phases] - spread[best];
        const double after = spread[(best + 1) % phases] - spread[best];
        const double offset =
            before + after > 0.0 ? 0.5 * (before - after) / (before + after) : 0.0;
        return at(arcs, (double(best) + offset) / phases);
    }

  private:
    static constexpr std::size_t phases = 64;

    /// Of the differences from their mean, squared.
    static double spread_of(const geom::Polyline& line, const std::vector<Vec3>& points) {
        Vec3 mean = Vec3::Zero();
        double squares = 0.0;
        for (std::size_t i = 0; i < line.size(); ++i) {
            mean += (points[i] - line[i]) / double(line.size());
            squares += (points[i] - line[i]).squaredNorm();
        }
        return squares - double(line.size()) * mean.squaredNorm();
    }

    [[nodiscard]] std::vector<Vec3> at(const std::vector<double>& shares, double shift) const {
        std::vector<Vec3> points;
        for (const double share : shares) {
            const double arc = (share + shift - std::floor(share + shift)) * start_.back();
            const auto next = std::upper_bound(start_.begin() + 1, start_.end() - 1, arc);
            const auto piece = std::size_t(next - start_.begin() - 1);
            const geom::ArcRange& range = path_[piece].range;
            const double along = arc - start_[piece];
            points.push_back(reference_
                                 .point_on_curve(path_[piece].curve, path_[piece].reversed
                                                                         ? range.to - along
                                                                         : range.from + along)
                                 .point);
        }
        return points;
    }

    const geom::ReferenceSurface& reference_;
    const FeaturePath& path_;
    std::vector<double> start_{0.0};
};

/// What chains go to.
enum class ChainTies {
    Shares,  ///< points at the same shares of the arc length: as far as they may be
    Nearest  ///< lines through the nearest points, in order
};

class Registering {
  public:
    Registering(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                const FitOptions& options)
        : cage_(cage),
          reference_(reference),
          options_(options),
          curves_(curve_sites(*cage.topology)),
          corners_(corner_vertices(*cage.topology)),
          surface_(*cage.topology, {interior_grid(samples_along)}, some_face_sites(*cage.topology),
                   subd::SampleRows::PointsAndTangents) {
        options_.feature_reach_rel = std::max(options_.feature_reach_rel, reach_rel);
    }

    Registration run(int finest, const ModelChange* change) && {
        Registration result;
        if (change != nullptr) {
            follow(*change, finest, result.stages);
        } else if (ties_of(cage_.points).rms > near_share * options_.tolerance_mm) {
            chain_ties_ = ChainTies::Shares;
            stage(0, result.stages);
            stage(coarsest, result.stages);
            chain_ties_ = ChainTies::Nearest;
            for (int cells = coarsest; cells <= finest && is_small(cells); cells *= 2) {
                stage(cells, result.stages);
                if (result.stages.back().rms_mm <= near_share * options_.tolerance_mm) break;
            }
        }
        result.cage = std::move(cage_);
        return result;
    }

  private:
    /// Lattices are smooth, so that narrow faces keep their shape. What is left of the
    /// displacements of limit points is taken as that of control points, whose masks are weights of
    /// means: unlike an interpolation it does not overshoot where the change has kinks.
    void follow(const ModelChange& change, int finest, std::vector<WarpStage>& stages) {
        surface_.apply(cage_.points, known_);
        move(known_, change);
        Points wanted = limit_positions(cage_);
        move(wanted, change);
        for (int cells = 0; cells <= finest && is_small(cells);
             cells = std::max(coarsest, 2 * cells))
            stage(cells, stages);
        known_.resize(0, 3);
        cage_.points = moved_by(cage_.points, wanted - limit_positions(cage_));
    }

    static void move(Points& points, const ModelChange& change) {
        base::parallel_for(std::size_t(points.rows()), 16, [&](std::size_t first, std::size_t end) {
            for (auto i = Eigen::Index(first); i < Eigen::Index(end); ++i)
                points.row(i) += change.displacement_at(points.row(i).transpose()).transpose();
        });
    }

    [[nodiscard]] bool is_small(int cells) const {
        return cells == 0 || DisplacementBasis::lattice_size(geom::bounding_box(cage_.points),
                                                             cells) <= most_nodes;
    }

    /// @param cells  of the lattice; 0: an affine map
    void stage(int cells, std::vector<WarpStage>& stages) {
        const auto start = std::chrono::steady_clock::now();
        const Points given = cage_.points;
        const geom::Box3 box = geom::bounding_box(given);
        const DisplacementBasis basis =
            cells == 0 ? DisplacementBasis::affine(box) : DisplacementBasis::lattice(box, cells);
        const DisplacementBasis::Values of_vertices = basis.values(given);
        Ties ties = ties_of(given);
        const DisplacementBasis::Values of_samples = basis.values(ties.at);
        Points coefficients = Points::Zero(basis.size(), 3);
        WarpStage figures{.cells = cells, .rms_mm = ties.rms, .max_mm = ties.max};
        double stiffness = first_stiffness;
        for (; figures.steps < max_steps; ++figures.steps) {
            base::report_progress(options_.progress, "carry", double(figures.steps) / max_steps);
            coefficients += step(ties, of_samples, basis.stiffness() * stiffness, coefficients);
            const Points moved = moved_by(given, of_vertices * coefficients);
            ties = ties_of(moved);
            const bool little = ties.rms > little_gain * figures.rms_mm;
            if (ties.rms < figures.rms_mm) {
                cage_.points = moved;
                figures.rms_mm = ties.rms;
                figures.max_mm = ties.max;
            }
            if (little && stiffness <= least_stiffness) break;
            stiffness = std::max(stiffness_factor * stiffness, least_stiffness);
        }
        figures.seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        stages.push_back(figures);
    }

    [[nodiscard]] Points moved_by(const Points& given, const Points& displacement) const {
        Points moved = given + displacement;
        for (const mesh::VertexId v : cage_.topology->vertices())
            if (cage_.topology->is_pinned(v)) moved.row(v.value) = given.row(v.value);
        return moved;
    }

    /// Change of the coefficients that minimises distances and stiffness.
    static Points step(const Ties& ties, const DisplacementBasis::Values& values,
                       const Eigen::MatrixXd& stiffness, const Points& coefficients) {
        const Eigen::Index n = values.cols();
        Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(3 * n, 3 * n);
        Eigen::VectorXd right = Eigen::VectorXd::Zero(3 * n);
        double weight = 0.0;
        for (Eigen::Index row = 0; row < values.rows(); ++row) {
            const Matrix3& metric = ties.metric[std::size_t(row)];
            if (metric.isZero(0.0)) continue;
            weight += metric.trace();
            const Vec3 pull = metric * (ties.target.row(row) - ties.at.row(row)).transpose();
            for (DisplacementBasis::Values::InnerIterator a(values, row); a; ++a) {
                right.segment<3>(3 * a.col()) += a.value() * pull;
                const Matrix3 scaled = a.value() * metric;
                for (DisplacementBasis::Values::InnerIterator b(values, row);
                     b && b.col() <= a.col(); ++b)
                    normal.block<3, 3>(3 * a.col(), 3 * b.col()) += b.value() * scaled;
            }
        }
        const double scale = std::max(weight, 1e-300);
        const Points force = scale * stiffness * coefficients;
        for (Eigen::Index a = 0; a < n; ++a) {
            right.segment<3>(3 * a) -= force.row(a).transpose();
            for (Eigen::Index b = 0; b <= a; ++b)
                normal.block<3, 3>(3 * a, 3 * b).diagonal().array() += scale * stiffness(a, b);
        }
        // Nodes that nothing depends on.
        normal.diagonal().array() += 1e-12 * normal.diagonal().maxCoeff();
        const Eigen::VectorXd solution =
            Eigen::LLT<Eigen::MatrixXd, Eigen::Lower>(normal).solve(right);
        return Eigen::Map<const Points>(solution.data(), n, 3);
    }

    [[nodiscard]] Ties known_ties(const Points& points) const {
        Ties ties(known_.rows());
        surface_.apply(points, ties.at);
        ties.target = known_;
        std::fill(ties.metric.begin(), ties.metric.end(), Matrix3::Identity());
        ties.sum_up();
        return ties;
    }

    [[nodiscard]] Ties ties_of(const Points& points) const {
        if (known_.rows() > 0) return known_ties(points);
        const mesh::Cage cage{cage_.topology, points};
        const int n = options_.solver.samples_per_edge;
        const Points on_curves = curve_points(cage, curves_, n);
        Ties ties(surface_.rows() + on_curves.rows() + Eigen::Index(corners_.size()));
        tie_surface(points, ties);
        ties.at.middleRows(surface_.rows(), on_curves.rows()) = on_curves;
        for (std::size_t i = 0; i < corners_.size(); ++i)
            ties.at.row(surface_.rows() + on_curves.rows() + Eigen::Index(i)) =
                points.row(corners_[i].value);
        if (!curves_.chains.empty()) tie_features(cage, on_curves, ties);
        ties.sum_up();
        return ties;
    }

    void tie_surface(const Points& points, Ties& ties) const {
        Points limit;
        surface_.apply(points, limit);
        const Points normals = surface_.normals(points);
        ties.at.topRows(limit.rows()) = limit;
        base::parallel_for(std::size_t(limit.rows()), 16, [&](std::size_t first, std::size_t end) {
            for (std::size_t i = first; i < end; ++i) {
                const auto row = Eigen::Index(i);
                const Vec3 normal = normals.row(row).transpose().normalized();
                if (normal.isZero(0.0)) continue;
                const auto foot = reference_.foot_point(limit.row(row).transpose(), normal);
                const double agreement = std::max(0.0, foot.normal.dot(normal));
                ties.target.row(row) = foot.point.transpose();
                ties.metric[i] = agreement * agreement * metric_of(foot.normal, true);
            }
        });
    }

    void tie_features(const mesh::Cage& cage, const Points& on_curves, Ties& ties) const {
        const int n = options_.solver.samples_per_edge;
        const FeatureMatch match = match_cage(cage, curves_, on_curves, reference_, options_);
        const Eigen::Index first_curve = surface_.rows(),
                           first_corner = first_curve + on_curves.rows();
        for (const VertexTarget& corner : match.corners) {
            const auto found = std::find(corners_.begin(), corners_.end(), corner.vertex);
            if (found == corners_.end()) continue;
            const Eigen::Index row = first_corner + (found - corners_.begin());
            ties.target.row(row) = corner.point.transpose();
            ties.metric[std::size_t(row)] = Matrix3::Identity();
        }
        for (std::size_t c = 0; c < curves_.chains.size(); ++c) {
            const EdgeChain& chain = curves_.chains[c];
            if (match.paths[c].empty()) continue;
            std::vector<Eigen::Index> rows;
            geom::Polyline line;
            for (const auto& [site, backwards] : chain.sites)
                for (int k = 0; k < n; ++k) {
                    rows.push_back(site * n + (backwards ? n - 1 - k : k));
                    line.emplace_back(on_curves.row(rows.back()).transpose());
                }
            if (chain_ties_ == ChainTies::Shares) {
                const auto targets =
                    ShareOfPath(reference_, match.paths[c]).targets(line, chain.closed);
                for (std::size_t i = 0; i < rows.size(); ++i) {
                    const Eigen::Index row = first_curve + rows[i];
                    ties.target.row(row) = targets[i].transpose();
                    ties.metric[std::size_t(row)] = Matrix3::Identity();
                }
                continue;
            }
            const PathAlignment alignment(reference_, match.paths[c], chain.closed, line.size());
            const auto targets = alignment.targets(line);
            for (std::size_t i = 0; i < rows.size(); ++i) {
                const Eigen::Index row = first_curve + rows[i];
                ties.target.row(row) = targets[i].point.transpose();
                ties.metric[std::size_t(row)] = metric_of(targets[i].tangent, false);
            }
        }
    }

    mesh::Cage cage_;
    const geom::ReferenceSurface& reference_;
    FitOptions options_;
    CurveSampling curves_;
    std::vector<mesh::VertexId> corners_;
    subd::LimitOperator surface_;
    ChainTies chain_ties_ = ChainTies::Nearest;
    Points known_;  ///< where samples of the surface belong; empty: not known
};

}  // namespace

Registration registered(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                        const FitOptions& options, int finest, const ModelChange* change) {
    return Registering(cage, reference, options).run(finest, change);
}

}  // namespace patchwright::fit
