#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/measure/fairness.h>
#include <patchwright/subd/limit_mask.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

namespace patchwright::measure {

namespace {

using geom::Vec3;
using mesh::CornerId;
using mesh::FaceId;

/// Normal curvature of the isoline with these derivatives.
double normal_curvature(const Vec3& d, const Vec3& dd, const Vec3& normal) {
    const double square = d.squaredNorm();
    return square > 0.0 ? dd.dot(normal) / square : 0.0;
}

struct FairnessSums {
    double area = 0.0, variation = 0.0, skew = 0.0;
    double largest_cosine = 0.0;
    std::array<double, 2> length{};  // of the isolines along u and v, on average

    void add(const FairnessSums& other) {
        area += other.area;
        variation += other.variation;
        skew += other.skew;
        largest_cosine = std::max(largest_cosine, other.largest_cosine);
    }
};

FairnessSums face_sums(const mesh::Cage& cage, const subd::LimitEvaluator& evaluator, FaceId f,
                       int n) {
    std::vector<subd::LimitPoint> grid;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j)
            grid.push_back(evaluator.evaluate(cage.points, {f, (i + 0.5) / n, (j + 0.5) / n}));
    }
    const auto at = [&](int i, int j) -> const subd::LimitPoint& {
        return grid[std::size_t(i * n + j)];
    };
    FairnessSums sums;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const subd::LimitPoint& p = at(i, j);
            const double area = p.du.cross(p.dv).norm() / (n * n);
            const double lengths = p.du.norm() * p.dv.norm();
            const double cosine = lengths > 0.0 ? std::abs(p.du.dot(p.dv)) / lengths : 1.0;
            sums.area += area;
            sums.skew += area * cosine * cosine;
            sums.largest_cosine = std::max(sums.largest_cosine, std::min(cosine, 1.0));
            sums.length[0] += p.du.norm() / (n * n);
            sums.length[1] += p.dv.norm() / (n * n);
            const auto change = [&](const subd::LimitPoint& q, bool u) {
                const double a = u ? normal_curvature(p.du, p.duu, p.normal)
                                   : normal_curvature(p.dv, p.dvv, p.normal);
                const double b = u ? normal_curvature(q.du, q.duu, q.normal)
                                   : normal_curvature(q.dv, q.dvv, q.normal);
                const double step = (q.position - p.position).norm();
                if (!(step > 0.0)) return;
                // Between samples: n - 1 places stand for n.
                sums.variation += area * n / (n - 1.0) * std::pow((b - a) / step, 2);
            };
            if (i + 1 < n) change(at(i + 1, j), true);
            if (j + 1 < n) change(at(i, j + 1), false);
        }
    }
    return sums;
}

}  // namespace

Fairness measure_fairness(const mesh::Cage& cage, int samples) {
    if (samples < 3) throw base::InvalidArgument("measure_fairness: at least 3 samples an edge");
    const mesh::Topology& t = *cage.topology;
    const subd::LimitEvaluator evaluator(cage.topology);
    std::vector<FairnessSums> faces(std::size_t(t.face_count()));
    base::parallel_for(faces.size(), 16, [&](std::size_t first, std::size_t last) {
        for (std::size_t f = first; f < last; ++f) {
            const FaceId face{static_cast<std::int32_t>(f)};
            if (t.size(face) == 4) faces[f] = face_sums(cage, evaluator, face, samples);
        }
    });
    FairnessSums sums;
    for (const FairnessSums& face : faces) sums.add(face);
    // Across an edge, isolines of the family that crosses it go on.
    double ratios = 0.0;
    int count = 0;
    const auto across = [&](CornerId c) {
        const int side = c.value - t.corners(t.face(c))[0].value;
        return faces[t.face(c).index()].length[side % 2 == 0 ? 1 : 0];
    };
    for (const mesh::EdgeId e : t.edges()) {
        const CornerId c = t.corner(e), d = t.twin(c);
        if (!d.valid() || std::isinf(t.sharpness(e))) continue;
        if (t.size(t.face(c)) != 4 || t.size(t.face(d)) != 4) continue;
        const double a = across(c), b = across(d);
        if (!(a > 0.0) || !(b > 0.0)) continue;
        ratios += std::pow(std::log2(a / b), 2);
        ++count;
    }
    Fairness result;
    if (!(sums.area > 0.0)) return result;
    const double diagonal = geom::bounding_box(cage.points).diagonal();
    result.curvature_variation = std::sqrt(sums.variation / sums.area) * diagonal * diagonal;
    result.skew = std::sqrt(sums.skew / sums.area);
    result.least_angle_rad = std::acos(sums.largest_cosine);
    result.uneven_spacing = count > 0 ? std::sqrt(ratios / count) : 0.0;
    return result;
}

}  // namespace patchwright::measure
