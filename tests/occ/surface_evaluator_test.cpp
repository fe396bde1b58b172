// Native evaluation against the kernel's, surface kind by surface kind.
#include "occ/foot/surface_evaluator.h"

#include <GeomConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <catch2/catch.hpp>
#include <gp_Ax3.hxx>
#include <gp_Elips.hxx>

#include <random>

using namespace patchwright;
using geom::Vec3;
using occ::Vec2;

namespace {

/// Axes that are neither at the origin nor right-handed.
gp_Ax3 axes() {
    gp_Ax3 result(gp_Pnt(1, -2, 3), gp_Dir(1, 2, -1), gp_Dir(2, 0, 2));
    result.YReverse();
    return result;
}

void check_against_kernel(const Handle(Geom_Surface) & surface, const Vec2& low, const Vec2& high) {
    const auto evaluator = occ::make_evaluator(surface);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (int i = 0; i < 200; ++i) {
        const Vec2 uv = low + Vec2(share(random), share(random)).cwiseProduct(high - low);
        gp_Pnt p;
        gp_Vec u, v, uu, vv, uv2;
        surface->D2(uv[0], uv[1], p, u, v, uu, vv, uv2);
        const occ::SurfaceDerivatives d = evaluator->derivatives(uv);
        CAPTURE(uv.transpose());
        CHECK((d.p - occ::vec(p)).norm() < 1e-11);
        CHECK((evaluator->at(uv) - occ::vec(p)).norm() < 1e-11);
        CHECK((d.u - occ::vec(u)).norm() < 1e-9);
        CHECK((d.v - occ::vec(v)).norm() < 1e-9);
        // Second derivatives lose digits where spans are short.
        const double scale = 1.0 + uu.Magnitude() + vv.Magnitude() + uv2.Magnitude();
        CHECK((d.uu - occ::vec(uu)).norm() < 1e-10 * scale);
        CHECK((d.uv - occ::vec(uv2)).norm() < 1e-10 * scale);
        CHECK((d.vv - occ::vec(vv)).norm() < 1e-10 * scale);
        const occ::SurfaceTangents tangents = evaluator->tangents(uv);
        CHECK((tangents.p - d.p).norm() < 1e-13 * scale);
        CHECK((tangents.u - d.u).norm() < 1e-12 * scale);
        CHECK((tangents.v - d.v).norm() < 1e-12 * scale);
    }
}

/// A wavy surface of the given degrees over uneven knots, with weights from 1 to `heaviest`.
Handle(Geom_BSplineSurface) wavy(int degree_u, int degree_v, double heaviest) {
    const int nu = degree_u + 4, nv = degree_v + 3;
    TColgp_Array2OfPnt poles(1, nu, 1, nv);
    TColStd_Array2OfReal weights(1, nu, 1, nv);
    for (int i = 1; i <= nu; ++i) {
        for (int j = 1; j <= nv; ++j) {
            poles(i, j) = gp_Pnt(2.0 * i, 1.5 * j, std::sin(1.0 * i * j));
            weights(i, j) = 1.0 + (heaviest - 1.0) * ((i * 7 + j * 3) % 5) / 4.0;
        }
    }
    const auto knots = [](int count, int degree, TColStd_Array1OfInteger& multiplicity) {
        TColStd_Array1OfReal result(1, count - degree + 1);
        for (int i = 1; i <= result.Length(); ++i) {
            result(i) = 0.3 * i + 0.05 * i * i;
            multiplicity(i) = i == 1 || i == result.Length() ? degree + 1 : 1;
        }
        return result;
    };
    TColStd_Array1OfInteger mu(1, nu - degree_u + 1), mv(1, nv - degree_v + 1);
    const TColStd_Array1OfReal ku = knots(nu, degree_u, mu), kv = knots(nv, degree_v, mv);
    return new Geom_BSplineSurface(poles, weights, ku, kv, mu, mv, degree_u, degree_v);
}

void check_whole(const Handle(Geom_Surface) & surface) {
    Vec2 low, high;
    surface->Bounds(low[0], high[0], low[1], high[1]);
    check_against_kernel(surface, low, high);
}

}  // namespace

TEST_CASE("closed forms agree with the kernel", "[occ][evaluator][oracle]") {
    const Vec2 low(-7.0, -1.5), high(7.0, 1.5);
    check_against_kernel(new Geom_Plane(axes()), low, high);
    check_against_kernel(new Geom_CylindricalSurface(axes(), 2.5), low, high);
    check_against_kernel(new Geom_ConicalSurface(axes(), 0.4, 2.5), low, high);
    check_against_kernel(new Geom_ConicalSurface(axes(), -0.4, 2.5), low, high);
    check_against_kernel(new Geom_SphericalSurface(axes(), 2.5), low, high);
    check_against_kernel(new Geom_ToroidalSurface(axes(), 4.0, 1.5), low, high);
}

TEST_CASE("closed-form feet are where all derivatives are at right angles to the way there",
          "[occ][evaluator][oracle]") {
    const std::vector<Handle(Geom_Surface)> surfaces{
        new Geom_Plane(axes()), new Geom_CylindricalSurface(axes(), 2.5),
        new Geom_ConicalSurface(axes(), 0.4, 2.5), new Geom_SphericalSurface(axes(), 2.5),
        new Geom_ToroidalSurface(axes(), 4.0, 1.5)};
    std::mt19937 random(4);
    std::uniform_real_distribution<double> place(-5.0, 5.0);
    for (const auto& surface : surfaces) {
        const auto evaluator = occ::make_evaluator(surface);
        for (int i = 0; i < 100; ++i) {
            const Vec3 q(place(random), place(random), place(random));
            const auto uv = evaluator->nearest(q);
            if (!uv) continue;
            const auto d = evaluator->derivatives(*uv);
            CHECK(std::abs((q - d.p).dot(d.u)) < 1e-9);
            CHECK(std::abs((q - d.p).dot(d.v)) < 1e-9);
            for (int k = 0; k < 50; ++k) {
                const Vec2 other(place(random), place(random));
                CHECK((evaluator->at(other) - q).norm() > (d.p - q).norm() - 1e-9);
            }
        }
        CHECK_FALSE((surface->DynamicType()->Name() != std::string("Geom_Plane") &&
                     evaluator->nearest(occ::vec(axes().Location())).has_value()));
    }
}

TEST_CASE("spans agree with the kernel", "[occ][evaluator][oracle]") {
    for (const auto& [p, q] : {std::pair(1, 1), {3, 3}, {3, 2}, {2, 5}, {5, 8}, {9, 1}}) {
        for (const double heaviest : {1.0, 3.0}) {
            CAPTURE(p, q, heaviest);
            check_whole(wavy(p, q, heaviest));
        }
    }
    // All weights equal, but not one.
    const auto heavy = wavy(3, 3, 1.0);
    TColStd_Array2OfReal weights(1, heavy->NbUPoles(), 1, heavy->NbVPoles());
    weights.Init(2.5);
    TColgp_Array2OfPnt poles(1, heavy->NbUPoles(), 1, heavy->NbVPoles());
    heavy->Poles(poles);
    check_whole(new Geom_BezierSurface(poles, weights));
}

TEST_CASE("periodic splines, trimmed, swept and other surfaces agree with the kernel",
          "[occ][evaluator][oracle]") {
    const Handle(Geom_Surface) torus = new Geom_ToroidalSurface(axes(), 4.0, 1.5);
    const Handle(Geom_BSplineSurface) spline = GeomConvert::SurfaceToBSplineSurface(torus);
    spline->SetUPeriodic();
    check_against_kernel(spline, Vec2(-3, 0), Vec2(9, 6));
    check_whole(new Geom_RectangularTrimmedSurface(wavy(3, 3, 2.0), 0.5, 1.5, 0.6, 1.2));
    const Handle(Geom_Curve) ellipse = new Geom_Ellipse(
        gp_Elips(gp_Ax2(gp_Pnt(6, 1, 0), gp_Dir(0, 1, 0.2), gp_Dir(1, 0, 0)), 2.0, 1.0));
    const gp_Ax1 axis(gp_Pnt(0, 1, 0), gp_Dir(0, 0.3, 1));
    check_against_kernel(new Geom_SurfaceOfRevolution(ellipse, axis), Vec2(0, 0), Vec2(6, 6));
    check_against_kernel(new Geom_SurfaceOfLinearExtrusion(ellipse, gp_Dir(1, 1, 2)), Vec2(0, -3),
                         Vec2(6, 3));
    check_against_kernel(new Geom_OffsetSurface(torus, 0.3), Vec2(0, 0), Vec2(6, 6));
}
