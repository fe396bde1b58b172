#include "occ/foot/face_surface.h"

#include "occ/foot/descent_limits.h"
#include "occ/foot/fused.h"

#include <BRep_Tool.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Precision.hxx>
#include <TColStd_Array1OfReal.hxx>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace patchwright::occ {

using geom::Vec3;

namespace {

double square(double x) { return x * x; }

/// Sine of the angle between the parameter lines below which curvature has no digits left.
constexpr double least_sine = 1e-7;
/// A parameter line is a point below this fraction of the model's size.
constexpr double point_rel = 1e-9;
/// How far inside the face a limit of normals is sampled, as a fraction of its parameters.
constexpr double beside_apex = 1e-5;
/// Cosine between sampled normals below which they have no common limit: 2.6 degrees.
constexpr double same_normal = 0.999;
/// Of a descent, and of each of its steps.
constexpr int max_steps = 50, max_halvings = 12;
/// A path ends in a known foot when one step brings it nearer by this factor, or when it is within
/// this fraction of the model's size.
constexpr double approach = 0.2, near_rel = 1e-6;
/// Fractions of a face's parameter range: beside a kink, and at a bound.
constexpr double off_kink = 1e-11, at_bound = 1e-10, across_kink = 1e-9;

// Minimum of g.x + x.Hx / 2 over low <= x <= high, for a positive definite H = [[a, b], [b, c]],
// where the free one lies outside.
Vec2 bounded_minimum(double a, double b, double c, const Vec2& g, const Vec2& free, const Vec2& low,
                     const Vec2& high) {
    const Eigen::Matrix2d h{{a, b}, {b, c}};
    Vec2 best = free;
    double best_value = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < 2; ++i) {
        if (free[i] >= low[i] && free[i] <= high[i]) continue;
        const Eigen::Index j = 1 - i;
        Vec2 x;
        x[i] = std::clamp(free[i], low[i], high[i]);
        x[j] = std::clamp(-(g[j] + h(j, i) * x[i]) / h(j, j), low[j], high[j]);
        const double value = g.dot(x) + 0.5 * x.dot(h * x);
        if (value < best_value) {
            best_value = value;
            best = x;
        }
    }
    return best;
}

}  // namespace

FaceSurface::FaceSurface(const TopoDS_Face& face, double size, std::pmr::memory_resource* memory)
    : size_(size) {
    TopLoc_Location location;
    BRep_Tool::Surface(face, location);
    surface_ = BRep_Tool::Surface(face);
    evaluator_ = make_evaluator(surface_, memory);
    trim_ = TrimRegion(face);
    if (face.Orientation() == TopAbs_REVERSED) orientation_ = -orientation_;
    if (location.Transformation().IsNegative()) orientation_ = -orientation_;
    set_rectangle();
    if (unbounded_) return;
    kinks_ = breaks(GeomAbs_C1);
    knots_ = breaks(GeomAbs_CN);
    // Cells end at kinks, so the descent cannot run around; the rectangle's ends are seeds enough.
    for (std::size_t i = 0; i < 2; ++i) wraps_[i] = wraps_[i] && kinks_[i].empty();
}

void FaceSurface::set_rectangle() {
    Vec2 low, high;
    surface_->Bounds(low[0], high[0], low[1], high[1]);
    low_ = trim_.empty() ? low : trim_.low();
    high_ = trim_.empty() ? high : trim_.high();
    const std::array<bool, 2> periodic{bool(surface_->IsUPeriodic()),
                                       bool(surface_->IsVPeriodic())};
    if (periodic[0]) period_[0] = surface_->UPeriod();
    if (periodic[1]) period_[1] = surface_->VPeriod();
    for (std::size_t i = 0; i < 2; ++i) {
        const auto k = Eigen::Index(i);
        if (periodic[i]) {
            wraps_[i] = high_[k] - low_[k] >= period_[i] * (1 - 1e-9);
        } else {
            low_[k] = std::max(low_[k], low[k]);
            high_[k] = std::min(high_[k], high[k]);
        }
        if (!(low_[k] < high_[k]) || Precision::IsInfinite(low_[k]) ||
            Precision::IsInfinite(high_[k]))
            unbounded_ = true;
    }
}

std::array<std::vector<double>, 2> FaceSurface::breaks(GeomAbs_Shape continuity) const {
    const GeomAdaptor_Surface adaptor(surface_, low_[0], high_[0], low_[1], high_[1]);
    const std::array<int, 2> count{adaptor.NbUIntervals(continuity),
                                   adaptor.NbVIntervals(continuity)};
    std::array<std::vector<double>, 2> result;
    for (std::size_t i = 0; i < 2; ++i) {
        TColStd_Array1OfReal at(1, count[i] + 1);
        if (i == 0)
            adaptor.UIntervals(at, continuity);
        else
            adaptor.VIntervals(at, continuity);
        for (int k = 2; k <= count[i]; ++k) result[i].push_back(at(k));
    }
    return result;
}

Vec3 FaceSurface::at(const Vec2& uv) const { return evaluator_->at(uv); }

std::optional<FaceSurface::PrincipalCurvature> FaceSurface::curvature(const Vec2& uv) const {
    const Derivatives d = derivatives(uv);
    const Vec3 cross = d.u.cross(d.v);
    const double sine = cross.norm();
    if (!(sine > least_sine * d.u.norm() * d.v.norm())) return std::nullopt;
    const Vec3 n = orientation_ / sine * cross;
    // The second form in an orthonormal frame: x along u, y across it.
    const double along = d.u.norm(), across = sine / along, shear = d.u.dot(d.v) / along;
    const Vec3 x = d.u / along, y = n.cross(x) * orientation_;
    const double l = d.uu.dot(n), m = d.uv.dot(n), k = d.vv.dot(n);
    const double xx = l / (along * along);
    const double xy = (m - shear * along * xx) / (along * across);
    const double yy = (k - 2.0 * shear * across * xy - shear * shear * xx) / (across * across);
    const double mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy), spread = std::hypot(half, xy);
    const double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
    const Vec3 most = std::cos(angle) * x + std::sin(angle) * y;
    return PrincipalCurvature{{mean - spread, mean + spread}, {n.cross(most), most}};
}

Vec3 FaceSurface::normal(const Vec2& uv) const {
    const SurfaceTangents d = evaluator_->tangents(uv);
    return normal_of(d.u, d.v, uv);
}

Vec3 FaceSurface::normal_of(const Vec3& du, const Vec3& dv, const Vec2& uv) const {
    const Vec2 range = high_ - low_;
    const double uu = du.squaredNorm(), vv = dv.squaredNorm(), flat = square(point_rel * size_);
    const bool flat_u = uu * range[0] * range[0] < flat, flat_v = vv * range[1] * range[1] < flat;
    const Vec3 cross = du.cross(dv);
    const double square = cross.squaredNorm();
    if (flat_u || flat_v || square <= 1e-14 * uu * vv) return limit_normal(uv, flat_u, flat_v);
    return orientation_ / std::sqrt(square) * cross;
}

Vec3 FaceSurface::limit_normal(const Vec2& uv, bool flat_u, bool flat_v) const {
    const Vec2 centre = 0.5 * (low_ + high_), range = high_ - low_;
    Vec3 first = Vec3::Zero(), sum = Vec3::Zero();
    for (const double s : {0.1, 0.3, 0.5, 0.7, 0.9}) {
        Vec2 near = uv + beside_apex * s * (centre - uv);
        // Along a side that is one point, the limit must be the same from everywhere.
        if (flat_u) near = {low_[0] + s * range[0], uv[1] + beside_apex * (centre[1] - uv[1])};
        if (flat_v && !flat_u)
            near = {uv[0] + beside_apex * (centre[0] - uv[0]), low_[1] + s * range[1]};
        const Derivatives d = derivatives(near);
        const Vec3 cross = d.u.cross(d.v);
        const double sine = cross.norm();
        if (!(sine > 0.0)) return Vec3::Zero();
        if (first.isZero(0.0)) first = cross / sine;
        if (first.dot(cross) < same_normal * sine) return Vec3::Zero();
        sum += cross / sine;
    }
    return orientation_ * sum.normalized();
}

bool FaceSurface::contains(const Vec2& uv) const {
    if (trim_.empty() || trim_.is_rectangle()) return true;
    Vec2 base = uv;
    for (std::size_t i = 0; i < 2; ++i) {
        const auto k = Eigen::Index(i);
        if (wraps_[i]) base[k] -= std::floor((base[k] - low_[k]) / period_[i]) * period_[i];
    }
    for (const int i : {0, 1}) {
        for (const int j : {0, 1}) {
            if ((i == 1 && !wraps_[0]) || (j == 1 && !wraps_[1])) continue;
            if (trim_.contains(base + Vec2(i * period_[0], j * period_[1]))) return true;
        }
    }
    return false;
}

FaceSurface::Rectangle FaceSurface::cell_of(const Vec2& uv) const {
    Rectangle cell{low_, high_};
    for (std::size_t i = 0; i < 2; ++i) {
        const auto k = Eigen::Index(i);
        if (wraps_[i]) {
            cell.low[k] = -1e300;
            cell.high[k] = 1e300;
            continue;
        }
        if (kinks_[i].empty()) continue;
        // At a kink the kernel evaluates one side's derivatives: stay off it by some bits.
        const double off = off_kink * (high_[k] - low_[k]);
        const auto above = std::upper_bound(kinks_[i].begin(), kinks_[i].end(), uv[k]);
        if (above != kinks_[i].begin()) cell.low[k] = *(above - 1) + off;
        if (above != kinks_[i].end()) cell.high[k] = *above - off;
    }
    return cell;
}

FaceSurface::Step FaceSurface::step(const DistanceTerms& d, const ParameterPair& at,
                                    const Rectangle& cell) {
    double a = d.uu + d.r_uu, b = d.uv + d.r_uv, c = d.vv + d.r_vv;
    const bool newton = a > definite_fraction * d.uu && c > definite_fraction * d.vv &&
                        a * c - b * b > definite_fraction * a * c;
    if (!newton) {
        // Gauss-Newton, kept regular where the surface is degenerate.
        a = d.uu * (1 + 1e-9) + 1e-30;
        b = d.uv * (1 - 1e-9);
        c = d.vv * (1 + 1e-9) + 1e-30;
    }
    const double scale = 1.0 / (a * c - b * b);
    const double du = (b * d.rv - c * d.ru) * scale, dv = (b * d.ru - a * d.rv) * scale;
    const double u = at.u + du, v = at.v + dv;
    if (u >= cell.low[0] && u <= cell.high[0] && v >= cell.low[1] && v <= cell.high[1])
        return {du, dv, newton};
    const Vec2 uv = at.uv();
    const Vec2 held =
        bounded_minimum(a, b, c, {d.ru, d.rv}, {du, dv}, cell.low - uv, cell.high - uv);
    return {held[0], held[1], newton};
}

PATCHWRIGHT_FUSED [[gnu::flatten]] FaceSurface::Foot FaceSurface::descend_in_fused(
    const Rectangle& cell, const Vec3& query, const Start& start,
    const std::vector<Vec2>& known) const {
    return descend_in_any(cell, query, start, known);
}

FaceSurface::Foot FaceSurface::descend_in(const Rectangle& cell, const Vec3& query,
                                          const Start& start,
                                          const std::vector<Vec2>& known) const {
    return has_fused_multiply_add ? descend_in_fused(cell, query, start, known)
                                  : descend_in_any(cell, query, start, known);
}

[[gnu::always_inline]] inline void FaceSurface::note_held(Foot& foot, const Rectangle& cell) const {
    for (std::size_t i = 0; i < 2; ++i) {
        const auto k = Eigen::Index(i);
        const double near = at_bound * (high_[k] - low_[k]);
        if (foot.uv[k] <= cell.low[k] + near) foot.held[i] = -1;
        if (foot.uv[k] >= cell.high[k] - near) foot.held[i] = 1;
    }
}

[[gnu::always_inline]] inline FaceSurface::Foot FaceSurface::descend_in_any(
    const Rectangle& cell, const Vec3& query, const Start& start,
    const std::vector<Vec2>& known) const {
    // Lengths are compared by their squares.
    const double final_step = square(final_step_rel * size_), none = square(no_step_rel * size_);
    const double negligible = square(rounding_rel * size_);
    ParameterPair at{std::clamp(start.uv[0], cell.low[0], cell.high[0]),
                     std::clamp(start.uv[1], cell.low[1], cell.high[1])};
    DistanceTerms d = evaluator_->distance_terms(at.uv(), query);
    SurfaceTangents end;
    bool arrived = false;
    double last_length = 0.0;  // of a whole step of Newton's, else 0
    for (int i = 0; i < max_steps; ++i) {
        const Step s = step(d, at, cell);
        const double length = d.squared_length(s.du, s.dv);
        if (!(length > none)) break;
        for (const Vec2& foot : known) {
            const double u = at.u - foot[0], v = at.v - foot[1];
            const double now = d.squared_length(u, v), then = d.squared_length(u + s.du, v + s.dv);
            if (s.newton && length < square(4.0 * start.stride) &&
                (then < square(approach) * now || now < square(near_rel * size_)) &&
                cell == cell_of(foot))
                return {foot, Vec3::Zero(), Vec3::Zero(), std::sqrt(d.rr), {0, 0}, true};
        }
        // Newton's own step is trusted somewhat farther than that of Gauss and Newton.
        const double farthest = s.newton ? 2.0 * start.stride : start.stride;
        double fraction = length > square(farthest) ? farthest / std::sqrt(length) : 1.0;
        // Newton's last step gains less than rounding shows.
        const bool last = s.newton && length < final_step;
        const auto is_better = [&](double squared) { return last || squared <= d.rr; };
        // Steps shrink with their square: what the next one would be follows from the last two.
        // When that is nothing, tangents are all that is asked for where this one ends.
        const bool arrives =
            s.newton && fraction == 1.0 &&
            (last || length * length * length < negligible * last_length * last_length);
        if (arrives) {
            const ParameterPair there = at.after(s, 1.0);
            end = evaluator_->tangents(there.uv());
            arrived = is_better((end.p - query).squaredNorm());
            if (arrived) {
                at = there;
                break;
            }
        }
        ParameterPair there = at.after(s, fraction);
        DistanceTerms next = evaluator_->distance_terms(there.uv(), query);
        for (int k = 1; k < max_halvings && !is_better(next.rr); ++k) {
            fraction *= 0.5;
            there = at.after(s, fraction);
            next = evaluator_->distance_terms(there.uv(), query);
        }
        if (!is_better(next.rr)) break;
        at = there;
        d = next;
        last_length = s.newton && fraction == 1.0 ? length : 0.0;
    }
    const Vec2 uv = at.uv();
    if (!arrived) end = evaluator_->tangents(uv);
    Foot foot{uv, end.p, normal_of(end.u, end.v, uv), (end.p - query).norm(), {0, 0}, false};
    note_held(foot, cell);
    return foot;
}

// Surfaces with a closed form have one local minimum at most, but for places where there are many.
std::optional<FaceSurface::Foot> FaceSurface::closed_form_foot(
    const Vec3& query, const std::vector<Vec2>& known) const {
    auto uv = evaluator_->nearest(query);
    if (!uv) return std::nullopt;
    const Vec2 range = high_ - low_;
    for (std::size_t i = 0; i < 2; ++i) {
        const auto k = Eigen::Index(i);
        if (period_[i] > 0.0) (*uv)[k] += std::ceil((low_[k] - (*uv)[k]) / period_[i]) * period_[i];
        if (!((*uv)[k] >= low_[k] && (*uv)[k] <= high_[k])) return std::nullopt;
    }
    Foot foot;
    foot.uv = *uv;
    for (const Vec2& other : known)
        foot.merged |= ((other - *uv).cwiseAbs().array() <= 1e-9 * range.array()).all();
    if (foot.merged) return foot;
    const Derivatives d = derivatives(*uv);
    foot.point = d.p;
    foot.normal = normal_of(d.u, d.v, *uv);
    foot.distance = (foot.point - query).norm();
    return foot;
}

FaceSurface::Foot FaceSurface::descend(const Vec3& query, const Start& start,
                                       const std::vector<Vec2>& known) const {
    if (const auto foot = closed_form_foot(query, known)) return *foot;
    Foot foot = descend_in(cell_of(start.uv), query, start, known);
    if (kinks_[0].empty() && kinks_[1].empty()) return foot;
    constexpr int max_hops = 8;
    for (int hop = 0; hop < max_hops && !foot.merged; ++hop) {
        Foot best = foot;
        for (std::size_t i = 0; i < 2; ++i) {
            if (foot.held[i] == 0) continue;
            Vec2 beyond = foot.uv;
            const auto k = Eigen::Index(i);
            beyond[k] += foot.held[i] * across_kink * (high_[k] - low_[k]);
            if (beyond[k] <= low_[k] || beyond[k] >= high_[k]) continue;
            const Foot other = descend_in(cell_of(beyond), query, {beyond, start.stride}, known);
            if (!other.merged && other.distance < best.distance - 1e-10 * size_) best = other;
        }
        if (best.distance >= foot.distance) break;
        foot = best;
    }
    // Held at a kink is not held at the face's rectangle.
    for (std::size_t i = 0; i < 2; ++i) {
        const auto k = Eigen::Index(i);
        const double near = across_kink * (high_[k] - low_[k]);
        if (foot.uv[k] > low_[k] + near && foot.uv[k] < high_[k] - near) foot.held[i] = 0;
    }
    return foot;
}

}  // namespace patchwright::occ
