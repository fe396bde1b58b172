#include "measure/near_curves.h"
#include "measure/normal_agreement.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/measure/folds.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace patchwright::measure {

using geom::Vec3;

namespace {

/// Samples inside each knot span, along each of its sides.
constexpr int samples_a_span = 4;

/// Neighbours in one span whose normals turn by less than this are looked at as one: what the input
/// turns by where the output does not is a matter of distance. A third of the limit.
constexpr double narrow_turn_rad = fold_limit_rad / 3.0;

/// Of one direction, evenly inside the knot spans that are not empty.
std::vector<double> sample_parameters(const std::vector<double>& knots) {
    std::vector<double> all;
    for (std::size_t k = 3; k + 4 < knots.size(); ++k)
        for (int i = 0; i < samples_a_span && knots[k] < knots[k + 1]; ++i)
            all.push_back(knots[k] +
                          (i + 0.5) / double(samples_a_span) * (knots[k + 1] - knots[k]));
    return all;
}

Vec3 unit_normal(const geom::BsplineSurface::Evaluation& e) {
    // Of a right angle's normal: less is rounding.
    constexpr double least_sine = 1e-12;
    const Vec3 n = e.du.cross(e.dv);
    const double size = n.norm();
    if (!(size > least_sine * e.du.norm() * e.dv.norm())) return Vec3::Zero();
    return n / size;
}

/// Points of a surface with unit normals du x dv, zero where it has none.
class SampledSurface {
  public:
    explicit SampledSurface(const geom::BsplineSurface& surface) {
        const auto us = sample_parameters(surface.knots_u), vs = sample_parameters(surface.knots_v);
        rows_ = int(us.size()), columns_ = int(vs.size());
        points_.reserve(us.size() * vs.size());
        normals_.reserve(us.size() * vs.size());
        for (const double u : us) {
            for (const double v : vs) {
                const auto e = surface.at(u, v);
                points_.push_back(e.position);
                normals_.push_back(unit_normal(e));
            }
        }
    }

    [[nodiscard]] int rows() const { return rows_; }
    [[nodiscard]] int columns() const { return columns_; }
    [[nodiscard]] const Vec3& point(int i, int j) const { return points_[index(i, j)]; }
    [[nodiscard]] const Vec3& normal(int i, int j) const { return normals_[index(i, j)]; }

  private:
    [[nodiscard]] std::size_t index(int i, int j) const {
        return std::size_t(i) * std::size_t(columns_) + std::size_t(j);
    }

    int rows_ = 0, columns_ = 0;
    std::vector<Vec3> points_, normals_;
};

/// Rows and columns of samples, the ends not among them.
struct Block {
    int i0, i1, j0, j1;
};

/// One surface: the samples of a span are parted until each part turns little and is settled.
class FoldSearch {
  public:
    FoldSearch(const SampledSurface& samples, int face, const NormalAgreement& agreement,
               const NearCurves& edges, double limit_rad)
        : samples_(samples), face_(face), agreement_(agreement), edges_(edges), limit_(limit_rad) {}

    FoldFigures run() {
        constexpr int step = samples_a_span;
        for (int i = 0; i < samples_.rows(); i += step)
            for (int j = 0; j < samples_.columns(); j += step) look_at({i, i + step, j, j + step});
        return figures_;
    }

  private:
    /// Those with a normal, and the most that one of them is turned from `normal`.
    [[nodiscard]] std::pair<int, double> turn_from(const Vec3& normal, const Block& b) const {
        int count = 0;
        double least_cosine = 1.0;
        for (int i = b.i0; i < b.i1; ++i) {
            for (int j = b.j0; j < b.j1; ++j) {
                const Vec3& n = samples_.normal(i, j);
                if (n.isZero()) continue;
                ++count;
                least_cosine = std::min(least_cosine, n.dot(normal));
            }
        }
        return {count, std::acos(std::clamp(least_cosine, -1.0, 1.0))};
    }

    void look_at(const Block& b) {
        const int i = (b.i0 + b.i1) / 2, j = (b.j0 + b.j1) / 2;
        const Vec3 &point = samples_.point(i, j), &normal = samples_.normal(i, j);
        const bool is_one = b.i1 - b.i0 == 1 && b.j1 - b.j0 == 1;
        if (normal.isZero()) {
            if (!is_one) part(b);
            return;
        }
        const auto [count, turn] = turn_from(normal, b);
        if (turn > narrow_turn_rad) return part(b);
        const auto agrees = [&](double angle) { return angle + turn <= limit_; };
        if (agrees(agreement_.angle_at_foot(point, normal))) {
            figures_.samples += count;
            return;
        }
        const bool exempt = edges_.is_near(point);
        const double least = exempt ? 0.0 : agreement_.least_angle(point, normal);
        const bool folds = !exempt && least > limit_ + turn;
        if (!is_one && !folds && (exempt || !agrees(least))) return part(b);
        figures_.samples += count;
        if (!folds) return;
        figures_.folded += count;
        if (!figures_.worst || least > figures_.worst->angle_rad)
            figures_.worst = Fold{point, face_, least};
    }

    void part(const Block& b) {
        const int i = (b.i0 + b.i1) / 2, j = (b.j0 + b.j1) / 2;
        if (b.i1 - b.i0 > b.j1 - b.j0) {
            look_at({b.i0, i, b.j0, b.j1});
            look_at({i, b.i1, b.j0, b.j1});
        } else {
            look_at({b.i0, b.i1, b.j0, j});
            look_at({b.i0, b.i1, j, b.j1});
        }
    }

    const SampledSurface& samples_;
    int face_;
    const NormalAgreement& agreement_;
    const NearCurves& edges_;
    double limit_;
    FoldFigures figures_;
};

/// Whether the larger part of the output's area faces the way that the input does.
double sign_of(const std::vector<geom::BsplineSurface>& surfaces,
               const geom::ReferenceSurface& input) {
    constexpr int side = 4;  // samples along each side of a surface
    std::vector<double> towards(surfaces.size());
    base::parallel_for(surfaces.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const geom::BsplineSurface& s = surfaces[k];
            const auto at = [](const std::vector<double>& knots, int i) {
                return knots.front() + (i + 0.5) / side * (knots.back() - knots.front());
            };
            const double cell = (s.knots_u.back() - s.knots_u.front()) *
                                (s.knots_v.back() - s.knots_v.front()) / (side * side);
            for (int i = 0; i < side * side; ++i) {
                const auto e = s.at(at(s.knots_u, i / side), at(s.knots_v, i % side));
                const Vec3 area = cell * e.du.cross(e.dv);
                const double cosine = area.dot(input.foot_point(e.position).normal);
                towards[k] += cosine > 0.0 ? area.norm() : cosine < 0.0 ? -area.norm() : 0.0;
            }
        }
    });
    return std::accumulate(towards.begin(), towards.end(), 0.0) < 0.0 ? -1.0 : 1.0;
}

}  // namespace

FoldFigures find_folds(const std::vector<geom::BsplineSurface>& surfaces,
                       const geom::ReferenceSurface& input, const FoldOptions& options) {
    if (!(options.tolerance_mm > 0.0) || !(options.angle_rad > 0.0))
        throw base::InvalidArgument("find_folds: the tolerance and the angle must be positive");
    const double sign = options.may_face_away ? sign_of(surfaces, input) : 1.0;
    const NormalAgreement agreement(input, options.tolerance_mm, options.angle_rad, sign);
    const NearCurves edges(input, options.creases, options.tolerance_mm);
    FoldFigures all;
    constexpr std::size_t together = 64;
    std::vector<FoldFigures> found(std::min(together, surfaces.size()));
    for (std::size_t start = 0; start < surfaces.size(); start += together) {
        base::report_progress(options.progress, "folds", double(start) / double(surfaces.size()));
        const std::size_t count = std::min(together, surfaces.size() - start);
        base::parallel_for(count, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const SampledSurface samples(surfaces[start + k]);
                FoldSearch search(samples, int(start + k), agreement, edges, options.angle_rad);
                found[k] = search.run();
            }
        });
        for (std::size_t k = 0; k < count; ++k) {
            all.samples += found[k].samples;
            all.folded += found[k].folded;
            const auto& worst = found[k].worst;
            if (!worst) continue;
            if (!all.worst || worst->angle_rad > all.worst->angle_rad) all.worst = worst;
            all.by_face.push_back(*worst);
        }
    }
    return all;
}

}  // namespace patchwright::measure
