#include "occ/foot/spline_spans.h"

#include "occ/foot/fused.h"
#include "occ/foot/spline_axis.h"

#include <GeomConvert_BSplineSurfaceToBezierSurface.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <TColStd_Array1OfReal.hxx>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

namespace patchwright::occ {

using geom::Vec3;

namespace {

using Vec4 = Eigen::Vector4d;

constexpr int max_degree = 15;
// Lofts come out rational with weights that differ by rounding only.
constexpr double equal_weights = 1e-12;

/// From Bernstein coefficients on [0, 1] to powers of x in [-1, 1]; column i holds B_i.
Eigen::MatrixXd powers_of_bernstein(int degree) {
    // (1+x)^i (1-x)^(n-i) C(n,i) / 2^n, multiplied out factor by factor.
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(degree + 1, degree + 1);
    double binomial = 1.0;
    for (int i = 0; i <= degree; ++i) {
        Eigen::VectorXd p = Eigen::VectorXd::Zero(degree + 1);
        p[0] = binomial;
        for (int k = 0; k < degree; ++k) {
            const double sign = k < i ? 1.0 : -1.0;
            for (int j = k + 1; j > 0; --j) p[j] = 0.5 * (p[j] + sign * p[j - 1]);
            p[0] *= 0.5;
        }
        result.col(i) = p;
        binomial *= double(degree - i) / double(i + 1);
    }
    return result;
}

/// @tparam p, q  degrees in u and v, or -1: as given at run time
template <int p, int q, bool rational>
class alignas(64) SplineSpans final : public SurfaceEvaluator {
  public:
    SplineSpans(const SplineAxis& u, const SplineAxis& v, int degree_u, int degree_v,
                const std::vector<Vec4>& coefficients, std::pmr::memory_resource* memory)
        : first_u_(u.line()),
          first_v_(v.line()),
          single_(u.is_line() && v.is_line()),
          degree_u_(degree_u),
          degree_v_(degree_v),
          numbers_(memory),
          u_(u, memory),
          v_(v, memory) {
        numbers_.reserve(stride * coefficients.size() + 1);
        for (const Vec4& c : coefficients)
            numbers_.insert(numbers_.end(), c.begin(), c.begin() + stride);
        numbers_.push_back(0.0);  // may be read behind the last one
        coefficients_ = numbers_.data();
    }

    SurfaceDerivatives derivatives(const Vec2& uv) const override {
        SurfaceDerivatives d;
        if (has_fused_multiply_add)
            second_order_fused(uv, d);
        else
            second_order(uv, d);
        return d;
    }
    DistanceTerms distance_terms(const Vec2& uv, const Vec3& query) const override {
        DistanceTerms d;
        if (has_fused_multiply_add)
            distance_terms_fused(uv, query, d);
        else
            distance_terms(uv, query, d);
        return d;
    }
    SurfaceTangents tangents(const Vec2& uv) const override {
        SurfaceTangents d;
        if (has_fused_multiply_add)
            first_order_fused(uv, d);
        else
            first_order(uv, d);
        return d;
    }

    Vec3 at(const Vec2& uv) const override {
        using Coefficient = Eigen::Matrix<double, stride, 1>;
        const auto [a, b] = find(uv);
        const int last_row = degree_u(), columns = degree_v() + 1;
        const double* row = span(a, b) + last_row * columns * stride;
        Coefficient s = Coefficient::Zero();
        for (int i = last_row; i >= 0; --i, row -= columns * stride) {
            Coefficient c(row + (columns - 1) * stride);
            for (int j = columns - 2; j >= 0; --j) c = c * b.x + Coefficient(row + j * stride);
            s = s * a.x + c;
        }
        if constexpr (rational) return s.template head<3>() / s[3];
        return s.template head<3>();
    }

  private:
    static constexpr int stride = rational ? 4 : 3;
    // Four doubles in one register, or in two: GCC's and Clang's vectors. Never passed by value, as
    // that depends on the processor.
    using Quad [[gnu::vector_size(4 * sizeof(double))]] = double;

    // The same code for two kinds of processor.
    PATCHWRIGHT_FUSED void second_order_fused(const Vec2& uv, SurfaceDerivatives& d) const {
        second_order(uv, d);
    }
    PATCHWRIGHT_FUSED void distance_terms_fused(const Vec2& uv, const Vec3& query,
                                                DistanceTerms& d) const {
        distance_terms(uv, query, d);
    }
    PATCHWRIGHT_FUSED void first_order_fused(const Vec2& uv, SurfaceTangents& d) const {
        first_order(uv, d);
    }

    [[gnu::always_inline]] void second_order(const Vec2& uv, SurfaceDerivatives& d) const {
        const auto [a, b] = find(uv);
        Quad s, su, sv, suu, suv, svv;
        second_order(a, b, s, su, sv, suu, suv, svv);
        store(s, d.p);
        store(su, d.u);
        store(sv, d.v);
        store(suu, d.uu);
        store(suv, d.uv);
        store(svv, d.vv);
    }

    [[gnu::always_inline]] void distance_terms(const Vec2& uv, const Vec3& query,
                                               DistanceTerms& d) const {
        const auto [a, b] = find(uv);
        Quad s, su, sv, suu, suv, svv;
        second_order(a, b, s, su, sv, suu, suv, svv);
        const Quad r = s - Quad{query[0], query[1], query[2], s[3]};
        su[3] = sv[3] = 0.0;  // r[3] is 0: the others' last places do not matter
        Quad first, second;
        dot(r, r, r, su, r, sv, su, su, first);
        dot(su, sv, sv, sv, r, suu, r, suv, second);
        d.rr = first[0];
        d.ru = first[1];
        d.rv = first[2];
        d.uu = first[3];
        d.uv = second[0];
        d.vv = second[1];
        d.r_uu = second[2];
        d.r_uv = second[3];
        const Quad last = r * svv;
        d.r_vv = (last[0] + last[1]) + last[2];
    }
    /// Four scalar products at once.
    [[gnu::always_inline]] static void dot(const Quad& a, const Quad& b, const Quad& c,
                                           const Quad& d, const Quad& e, const Quad& f,
                                           const Quad& g, const Quad& h, Quad& products) {
        const Quad ab = a * b, cd = c * d, ef = e * f, gh = g * h;
        const Quad low = __builtin_shufflevector(ab, cd, 0, 4, 2, 6) +
                         __builtin_shufflevector(ab, cd, 1, 5, 3, 7);
        const Quad high = __builtin_shufflevector(ef, gh, 0, 4, 2, 6) +
                          __builtin_shufflevector(ef, gh, 1, 5, 3, 7);
        products = __builtin_shufflevector(low, high, 0, 1, 4, 5) +
                   __builtin_shufflevector(low, high, 2, 3, 6, 7);
    }

    [[gnu::always_inline]] void second_order(const SpanPlace& a, const SpanPlace& b, Quad& s,
                                             Quad& su, Quad& sv, Quad& suu, Quad& suv,
                                             Quad& svv) const {
        const int last_row = degree_u(), columns = degree_v() + 1;
        const double* row = span(a, b) + last_row * columns * stride;
        s = su = suu = sv = suv = svv = Quad{};
        // Horner's rule in both parameters; second derivatives come out halved.
        for (int i = last_row; i >= 0; --i, row -= columns * stride) {
            Quad c, cv{}, cvv{}, next;
            load(row + (columns - 1) * stride, c);
            for (int j = columns - 2; j >= 0; --j) {
                load(row + j * stride, next);
                cvv = cvv * b.x + cv;
                cv = cv * b.x + c;
                c = c * b.x + next;
            }
            suu = suu * a.x + su;
            su = su * a.x + s;
            s = s * a.x + c;
            suv = suv * a.x + sv;
            sv = sv * a.x + cv;
            svv = svv * a.x + cvv;
        }
        su *= a.scale;
        suu *= 2.0 * a.scale * a.scale;
        sv *= b.scale;
        svv *= 2.0 * b.scale * b.scale;
        suv *= a.scale * b.scale;
        if constexpr (rational) {
            // Quotient rule (Piegl, Tiller, The NURBS Book, 1997, 4.5).
            const double w = 1.0 / s[3], wu = su[3], wv = sv[3];
            const double wuu = suu[3], wuv = suv[3], wvv = svv[3];
            s *= w;
            su = (su - wu * s) * w;
            sv = (sv - wv * s) * w;
            suu = (suu - 2.0 * wu * su - wuu * s) * w;
            suv = (suv - wu * sv - wv * su - wuv * s) * w;
            svv = (svv - 2.0 * wv * sv - wvv * s) * w;
        }
    }

    [[gnu::always_inline]] void first_order(const Vec2& uv, SurfaceTangents& d) const {
        const auto [a, b] = find(uv);
        const int last_row = degree_u(), columns = degree_v() + 1;
        const double* row = span(a, b) + last_row * columns * stride;
        Quad s{}, su{}, sv{};
        for (int i = last_row; i >= 0; --i, row -= columns * stride) {
            Quad c, cv{}, next;
            load(row + (columns - 1) * stride, c);
            for (int j = columns - 2; j >= 0; --j) {
                load(row + j * stride, next);
                cv = cv * b.x + c;
                c = c * b.x + next;
            }
            su = su * a.x + s;
            s = s * a.x + c;
            sv = sv * a.x + cv;
        }
        su *= a.scale;
        sv *= b.scale;
        if constexpr (rational) {
            const double w = 1.0 / s[3], wu = su[3], wv = sv[3];
            s *= w;
            su = (su - wu * s) * w;
            sv = (sv - wv * s) * w;
        }
        store(s, d.p);
        store(su, d.u);
        store(sv, d.v);
    }

    // Without weights the last number is that of the next coefficient, which nothing depends on.
    [[gnu::always_inline]] static void load(const double* from, Quad& to) {
        std::memcpy(&to, from, sizeof to);
    }
    [[gnu::always_inline]] static void store(const Quad& from, Vec3& to) {
        std::memcpy(to.data(), &from, 3 * sizeof(double));
    }

    [[nodiscard]] int degree_u() const { return p < 0 ? degree_u_ : p; }
    [[nodiscard]] int degree_v() const { return q < 0 ? degree_v_ : q; }
    [[nodiscard]] const double* span(const SpanPlace& a, const SpanPlace& b) const {
        if (single_) return coefficients_;
        const std::size_t size = std::size_t(degree_u() + 1) * std::size_t(degree_v() + 1) * stride;
        return coefficients_ + std::size_t(a.span * v_.spans() + b.span) * size;
    }
    [[gnu::always_inline]] std::pair<SpanPlace, SpanPlace> find(const Vec2& uv) const {
        if (single_) return {first_u_.find(uv[0]), first_v_.find(uv[1])};
        return {u_.find(uv[0]), v_.find(uv[1])};
    }

    // What one span asks for lies in one line of the cache: with many faces that is what is paid.
    SplineAxis::SingleSpan first_u_, first_v_;
    const double* coefficients_ = nullptr;
    bool single_;  ///< one span, not periodic
    int degree_u_, degree_v_;
    /// Span by span, v running first; in a span powers of u by powers of v, v running first. Three
    /// numbers each, or four with their weights.
    std::pmr::vector<double> numbers_;
    SplineAxis u_, v_;
};

bool has_equal_weights(const Geom_BSplineSurface& surface) {
    if (!surface.IsURational() && !surface.IsVRational()) return true;
    const double first = surface.Weight(1, 1);
    for (int i = 1; i <= surface.NbUPoles(); ++i) {
        for (int j = 1; j <= surface.NbVPoles(); ++j)
            if (std::abs(surface.Weight(i, j) - first) > equal_weights * std::abs(first))
                return false;
    }
    return true;
}

std::vector<double> distinct(const TColStd_Array1OfReal& knots) {
    return {knots.begin(), knots.end()};
}

/// The polynomials of one Bezier patch, appended.
void append_span(const Geom_BezierSurface& patch, bool rational, const Eigen::MatrixXd& basis_u,
                 const Eigen::MatrixXd& basis_v, std::vector<Vec4>& coefficients) {
    const Eigen::Index p = basis_u.rows(), q = basis_v.rows();
    std::array<Eigen::MatrixXd, 4> component;
    for (auto& m : component) m.resize(p, q);
    for (int i = 0; i < p; ++i) {
        for (int j = 0; j < q; ++j) {
            const Vec3 pole = vec(patch.Pole(i + 1, j + 1));
            const double weight = rational ? patch.Weight(i + 1, j + 1) : 1.0;
            for (int k = 0; k < 3; ++k) component[std::size_t(k)](i, j) = weight * pole[k];
            component[3](i, j) = weight;
        }
    }
    for (auto& m : component) m = (basis_u * m * basis_v.transpose()).eval();
    for (Eigen::Index i = 0; i < p; ++i) {
        for (Eigen::Index j = 0; j < q; ++j)
            coefficients.emplace_back(component[0](i, j), component[1](i, j), component[2](i, j),
                                      component[3](i, j));
    }
}

template <int p, int q>
std::shared_ptr<const SurfaceEvaluator> make(bool rational, const SplineAxis& u,
                                             const SplineAxis& v, int degree_u, int degree_v,
                                             const std::vector<Vec4>& coefficients,
                                             std::pmr::memory_resource* memory) {
    const std::pmr::polymorphic_allocator<> place(memory);
    if (rational)
        return std::allocate_shared<SplineSpans<p, q, true>>(place, u, v, degree_u, degree_v,
                                                             coefficients, memory);
    return std::allocate_shared<SplineSpans<p, q, false>>(place, u, v, degree_u, degree_v,
                                                          coefficients, memory);
}

Handle(Geom_BSplineSurface) one_span(const Geom_BezierSurface& bezier) {
    TColStd_Array1OfReal knots(1, 2);
    knots(1) = 0.0;
    knots(2) = 1.0;
    TColStd_Array1OfInteger u(1, 2), v(1, 2);
    u.Init(bezier.UDegree() + 1);
    v.Init(bezier.VDegree() + 1);
    TColgp_Array2OfPnt poles(1, bezier.NbUPoles(), 1, bezier.NbVPoles());
    bezier.Poles(poles);
    TColStd_Array2OfReal weights(1, bezier.NbUPoles(), 1, bezier.NbVPoles());
    bezier.Weights(weights);
    return new Geom_BSplineSurface(poles, weights, knots, knots, u, v, bezier.UDegree(),
                                   bezier.VDegree());
}

}  // namespace

std::shared_ptr<const SurfaceEvaluator> make_spline_spans(const Handle(Geom_Surface) & surface,
                                                          std::pmr::memory_resource* memory) {
    Handle(Geom_BSplineSurface) spline;
    if (const auto bezier = Handle(Geom_BezierSurface)::DownCast(surface); !bezier.IsNull()) {
        spline = one_span(*bezier);
    } else if (const auto given = Handle(Geom_BSplineSurface)::DownCast(surface); !given.IsNull()) {
        spline = Handle(Geom_BSplineSurface)::DownCast(given->Copy());
    }
    if (spline.IsNull() || spline->UDegree() > max_degree || spline->VDegree() > max_degree)
        return nullptr;
    const bool rational = !has_equal_weights(*spline);
    const bool periodic_u = spline->IsUPeriodic(), periodic_v = spline->IsVPeriodic();
    if (periodic_u) spline->SetUNotPeriodic();
    if (periodic_v) spline->SetVNotPeriodic();
    GeomConvert_BSplineSurfaceToBezierSurface spans(spline);
    const int nu = spans.NbUPatches(), nv = spans.NbVPatches();
    TColStd_Array1OfReal knots_u(1, nu + 1), knots_v(1, nv + 1);
    spans.UKnots(knots_u);
    spans.VKnots(knots_v);
    const int p = spline->UDegree(), q = spline->VDegree();
    const Eigen::MatrixXd basis_u = powers_of_bernstein(p), basis_v = powers_of_bernstein(q);
    std::vector<Vec4> coefficients;
    coefficients.reserve(std::size_t(nu) * std::size_t(nv) * std::size_t((p + 1) * (q + 1)));
    for (int i = 1; i <= nu; ++i) {
        for (int j = 1; j <= nv; ++j)
            append_span(*spans.Patch(i, j), rational, basis_u, basis_v, coefficients);
    }
    const SplineAxis u(distinct(knots_u), periodic_u), v(distinct(knots_v), periodic_v);
    if (p == 3 && q == 3) return make<3, 3>(rational, u, v, p, q, coefficients, memory);
    switch (q) {
        case 1: return make<-1, 1>(rational, u, v, p, q, coefficients, memory);
        case 2: return make<-1, 2>(rational, u, v, p, q, coefficients, memory);
        case 3: return make<-1, 3>(rational, u, v, p, q, coefficients, memory);
        default: return make<-1, -1>(rational, u, v, p, q, coefficients, memory);
    }
}

}  // namespace patchwright::occ
