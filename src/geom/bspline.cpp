#include <patchwright/geom/bspline.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace patchwright::geom {

BasisSpan cubic_basis(const std::vector<double>& knots, double t) {
    const auto last = knots.end() - 4;
    const auto upper = std::min(std::upper_bound(knots.begin() + 4, last, t), last);
    const auto span = upper - knots.begin() - 1;
    const double* k = knots.data() + span;

    BasisSpan basis{};
    basis.first = span - 3;
    double left[4];
    double right[4];
    double quadratic[3];
    double* n = basis.value;
    n[0] = 1.0;
    for (int degree = 1; degree <= 3; ++degree) {
        if (degree == 3) std::copy(n, n + 3, quadratic);
        left[degree] = t - k[1 - degree];
        right[degree] = k[degree] - t;
        double saved = 0.0;
        for (int r = 0; r < degree; ++r) {
            const double part = n[r] / (right[r + 1] + left[degree - r]);
            n[r] = saved + right[r + 1] * part;
            saved = left[degree - r] * part;
        }
        n[degree] = saved;
    }
    for (int r = 0; r < 4; ++r) {
        const double rising = r > 0 ? quadratic[r - 1] / (k[r] - k[r - 3]) : 0.0;
        const double falling = r < 3 ? quadratic[r] / (k[r + 1] - k[r - 2]) : 0.0;
        basis.derivative[r] = 3.0 * (rising - falling);
    }
    return basis;
}

Vec3 BsplineCurve::at(double t) const {
    const BasisSpan b = cubic_basis(knots, t);
    Vec3 p = Vec3::Zero();
    for (int i = 0; i < 4; ++i) p += b.value[i] * points.row(b.first + i).transpose();
    return p;
}

BsplineCurve reversed(const BsplineCurve& curve) {
    BsplineCurve result{{curve.knots.rbegin(), curve.knots.rend()},
                        curve.points.colwise().reverse()};
    for (double& knot : result.knots) knot = curve.begin() + (curve.end() - knot);
    return result;
}

namespace {

/// The blossom of the polynomial between the distinct knots `span` and span + 1 at three arguments.
/// @param d  the control points span - 3 to span
template <class Point>
Point blossom(const std::vector<double>& knots, std::size_t span, std::array<Point, 4> d,
              const double* arguments) {
    for (std::size_t r = 1; r <= 3; ++r) {
        for (std::size_t j = 3; j >= r; --j) {
            const double from = knots[span - 3 + j];
            const double to = knots[span + j + 1 - r];
            const double share = (arguments[r - 1] - from) / (to - from);
            d[j] = (1.0 - share) * d[j - 1] + share * d[j];
        }
    }
    return d[3];
}

/// Bases at the Gauss points of all spans, with the points' weights.
struct GaussBasis {
    BasisSpan basis;
    double weight;
};

std::vector<GaussBasis> gauss_bases(const std::vector<double>& knots) {
    // Six points: exact up to degree eleven, which the moments of a volume have in each parameter.
    constexpr double places[] = {-0.932469514203152, -0.661209386466265, -0.238619186083197,
                                 0.238619186083197,  0.661209386466265,  0.932469514203152};
    constexpr double weights[] = {0.171324492379170, 0.360761573048139, 0.467913934572691,
                                  0.467913934572691, 0.360761573048139, 0.171324492379170};
    std::vector<GaussBasis> bases;
    for (std::size_t k = 3; k + 4 < knots.size(); ++k) {
        const double half = 0.5 * (knots[k + 1] - knots[k]);
        if (!(half > 0.0)) continue;
        for (std::size_t g = 0; g < 6; ++g) {
            const double at = knots[k] + half * (1.0 + places[g]);
            bases.push_back({cubic_basis(knots, at), half * weights[g]});
        }
    }
    return bases;
}

}  // namespace

SurfaceMoments moments(const BsplineSurface& surface, const Vec3& origin) {
    const std::vector<GaussBasis> along_u = gauss_bases(surface.knots_u);
    const std::vector<GaussBasis> along_v = gauss_bases(surface.knots_v);
    const auto columns = std::size_t(surface.columns());
    std::vector<Vec3> across(columns), across_du(columns);  // the curve along v, and its du
    SurfaceMoments sum;
    for (const auto& [bu, weight_u] : along_u) {
        for (std::size_t j = 0; j < columns; ++j) {
            across[j] = -origin;
            across_du[j] = Vec3::Zero();
            for (int i = 0; i < 4; ++i) {
                const Vec3 control = surface.point(bu.first + i, Eigen::Index(j)).transpose();
                across[j] += bu.value[i] * control;
                across_du[j] += bu.derivative[i] * control;
            }
        }
        for (const auto& [bv, weight_v] : along_v) {
            Vec3 p = Vec3::Zero(), du = Vec3::Zero(), dv = Vec3::Zero();
            for (int k = 0; k < 4; ++k) {
                const auto j = std::size_t(bv.first + k);
                p += bv.value[k] * across[j];
                du += bv.value[k] * across_du[j];
                dv += bv.derivative[k] * across[j];
            }
            const Vec3 normal = weight_u * weight_v * du.cross(dv);
            const double area = normal.norm();
            sum.area += area;
            sum.of_area += area * p;
            const double flux = p.dot(normal);
            sum.volume += flux / 3.0;
            sum.of_volume += 0.25 * flux * p;
        }
    }
    return sum;
}

BsplineCurve part(const BsplineCurve& curve, double begin, double end) {
    if (begin == curve.begin() && end == curve.end()) return curve;
    BsplineCurve result;
    result.knots.assign(4, begin);
    for (const double knot : curve.knots) {
        if (knot > begin && knot < end) result.knots.push_back(knot);
    }
    result.knots.insert(result.knots.end(), 4, end);
    const std::size_t count = result.knots.size() - 4;
    result.points.resize(Eigen::Index(count), 3);
    for (std::size_t i = 0; i < count; ++i) {
        // Any interval within the control point's support has its polynomial.
        std::size_t k = i;
        while (result.knots[k] == result.knots[k + 1]) ++k;
        const double middle = 0.5 * (result.knots[k] + result.knots[k + 1]);
        const auto after = std::upper_bound(curve.knots.begin(), curve.knots.end(), middle);
        const std::size_t span = std::size_t(after - curve.knots.begin()) - 1;
        std::array<Vec3, 4> control;
        for (std::size_t j = 0; j < 4; ++j)
            control[j] = curve.points.row(Eigen::Index(span - 3 + j));
        result.points.row(Eigen::Index(i)) =
            blossom(curve.knots, span, control, &result.knots[i + 1]);
    }
    return result;
}

Eigen::Matrix4d bezier_matrix(const std::vector<double>& knots, Eigen::Index span) {
    const double a = knots[std::size_t(span)], b = knots[std::size_t(span) + 1];
    const double arguments[] = {a, a, a, b, b, b};
    std::array<Eigen::Vector4d, 4> unit;
    for (std::size_t k = 0; k < 4; ++k) unit[k] = Eigen::Vector4d::Unit(Eigen::Index(k));
    Eigen::Matrix4d matrix;
    for (Eigen::Index k = 0; k < 4; ++k)
        matrix.row(k) = blossom(knots, std::size_t(span), unit, arguments + k);
    return matrix;
}

BsplineSurface::Evaluation BsplineSurface::at(double u, double v) const {
    const BasisSpan bu = cubic_basis(knots_u, u);
    const BasisSpan bv = cubic_basis(knots_v, v);
    Evaluation e{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    for (int i = 0; i < 4; ++i) {
        Vec3 row = Vec3::Zero();
        Vec3 row_dv = Vec3::Zero();
        for (int j = 0; j < 4; ++j) {
            const Vec3 p = point(bu.first + i, bv.first + j).transpose();
            row += bv.value[j] * p;
            row_dv += bv.derivative[j] * p;
        }
        e.position += bu.value[i] * row;
        e.du += bu.derivative[i] * row;
        e.dv += bu.value[i] * row_dv;
    }
    return e;
}

}  // namespace patchwright::geom
