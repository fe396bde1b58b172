#include "make_aircraft.h"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepLib.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <TopoDS.hxx>
#include <gp_Ax1.hxx>
#include <gp_Ax2.hxx>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace lofts;

namespace aircraft {

namespace {

constexpr double pi = std::numbers::pi;
constexpr int section_side = 10;    // intervals from nose to trailing edge
constexpr double cap_aspect = 1.5;  // of rounded tips: their length over half the thickness

double bernstein_sum(const std::array<double, 4>& a, double x) {
    const double y = 1 - x;
    return y * y * y * a[0] + 3 * x * y * y * a[1] + 3 * x * x * y * a[2] + x * x * x * a[3];
}

/// `s` from the lower trailing edge (-1) over the nose (0) to the upper one (1): x = s * s.
gp_XY airfoil_point(const Airfoil& airfoil, double s) {
    const double x = s * s;
    const double z = s * (1 - x) * bernstein_sum(s < 0 ? airfoil.lower : airfoil.upper, x);
    return {x, z + std::copysign(x * airfoil.base / 2, s)};
}

gp_XYZ thickness_direction(const Station& station) {
    return {0, -std::sin(station.roll), std::cos(station.roll)};
}

gp_Pnt skin_point(const Station& station, double s) {
    const gp_XY p = airfoil_point(station.airfoil, s) * station.chord;
    const double c = std::cos(station.twist), w = std::sin(station.twist);
    return station.nose.XYZ() + gp_XYZ(c * p.X() + w * p.Y(), 0, 0) +
           thickness_direction(station) * (c * p.Y() - w * p.X());
}

std::vector<double> section_parameters() {
    std::vector<double> s;
    for (int i = -section_side; i <= section_side; ++i) s.push_back(double(i) / section_side);
    return s;
}

/// Parameters across are lengths along the noses, from 0 at the first station.
Surface skin_of(const std::vector<Station>& stations, bool smooth_root) {
    std::vector<std::vector<gp_Pnt>> sections;
    std::vector<double> across;
    const std::vector<double> s = section_parameters();
    for (const Station& station : stations) {
        const Station& last = stations[across.empty() ? 0 : across.size() - 1];
        const gp_XYZ step = station.nose.XYZ() - last.nose.XYZ();
        across.push_back(across.empty() ? 0.0 : across.back() + std::hypot(step.Y(), step.Z()));
        sections.emplace_back();
        for (double si : s) sections.back().push_back(skin_point(station, si));
    }
    if (!smooth_root) return loft(sections, s, across);
    for (std::size_t j = 1; j < stations.size(); ++j) {
        across.insert(across.begin(), -across[2 * j - 1]);
        std::vector<gp_Pnt> image = sections[2 * j - 1];
        for (gp_Pnt& p : image) p.SetY(-p.Y());
        sections.insert(sections.begin(), image);
    }
    const Surface both = loft(sections, s, across);
    return part(both, -1, 1, 0, across.back());
}

struct Border {
    Curve upper, lower;  ///< from the nose aft
};

Border border_of(const Surface& skin, bool at_tip) {
    double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
    skin->Bounds(u0, u1, v0, v1);
    const double v = at_tip ? v1 : v0;
    Border border{as_spline(part(skin, 0, 1, v0, v1)->VIso(v)),
                  as_spline(part(skin, -1, 0, v0, v1)->VIso(v))};
    border.lower->Reverse();
    return border;
}

/// Closes a section by a plane face between its sides.
TopoDS_Face rib(const Border& border) { return face_of(ruled(border.lower, border.upper)); }

/// Leaves the skin along the lines of constant chord fraction, as straight ones run to the tip.
std::vector<TopoDS_Face> rounded_tip(const Border& border, const std::vector<Station>& stations) {
    const Station &last = stations.back(), &before = stations[stations.size() - 2];
    const gp_XYZ up = thickness_direction(last);
    const gp_XYZ side(0, std::cos(last.roll), std::sin(last.roll));
    const gp_XYZ step = last.nose.XYZ() - before.nose.XYZ();
    const Surface cap =
        rounded_cap(border.upper, border.lower, [&](const gp_XYZ& centre, const gp_XYZ& half) {
            const double fraction = std::clamp((centre.X() - last.nose.X()) / last.chord, 0.0, 1.0);
            const double aft = step.X() + fraction * (last.chord - before.chord);
            const gp_XYZ out = side + gp_XYZ(aft / step.Dot(side), 0, 0);
            return out * (cap_aspect * half.Dot(up));
        });
    std::vector<TopoDS_Face> faces{face_of(cap)};
    if (last.airfoil.base > 0)
        faces.push_back(face_of(ruled(as_spline(cap->UIso(1)),
                                      line(border.upper->EndPoint(), border.lower->EndPoint()))));
    return faces;
}

gp_Pnt fuselage_point(const gp_Pnt& centre, double radius, double height_ratio, double angle) {
    return {centre.X(), radius * std::sin(angle),
            centre.Z() + height_ratio * radius * std::cos(angle)};
}

}  // namespace

std::vector<TopoDS_Face> faces_of(const Wing& wing) {
    std::vector<TopoDS_Face> faces;
    for (std::size_t i = 0; i < wing.panels.size(); ++i) {
        const Surface skin = skin_of(wing.panels[i], wing.smooth_root && i == 0);
        double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
        skin->Bounds(u0, u1, v0, v1);
        const Surface upper = part(skin, 0, 1, v0, v1), lower = part(skin, -1, 0, v0, v1);
        faces.push_back(face_of(upper));
        faces.push_back(face_of(lower));
        if (wing.panels[i].front().airfoil.base > 0)
            faces.push_back(face_of(ruled(as_spline(lower->UIso(-1)), as_spline(upper->UIso(1)))));
        if (i == 0 && wing.closed_root) faces.push_back(rib(border_of(skin, false)));
        if (i + 1 < wing.panels.size()) continue;
        const Border border = border_of(skin, true);
        if (wing.tip == Tip::Plane) {
            faces.push_back(rib(border));
        } else {
            for (const TopoDS_Face& face : rounded_tip(border, wing.panels[i]))
                faces.push_back(face);
        }
    }
    return faces;
}

TopoDS_Shape mirror_image(const TopoDS_Shape& shape) {
    gp_Trsf mirror;
    mirror.SetMirror(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 1, 0)));
    return BRepBuilderAPI_Transform(shape, mirror, true).Shape();
}

std::vector<TopoDS_Face> with_mirror_image(const std::vector<TopoDS_Face>& faces) {
    std::vector<TopoDS_Face> both = faces;
    for (const TopoDS_Face& face : faces) both.push_back(TopoDS::Face(mirror_image(face)));
    return both;
}

/// Three faces that join with one tangent: nose, barrel, tail with its end.
std::vector<TopoDS_Face> faces_of(const Fuselage& f) {
    constexpr int around = 8, along = 6;  // intervals; around: in half a turn
    std::vector<double> angles, fractions;
    // A quarter turn beyond both ends: natural ends would not be level in the plane of symmetry.
    for (int i = -around / 2; i <= around * 3 / 2; ++i) angles.push_back(pi * i / around);
    for (int i = 0; i <= along; ++i) fractions.push_back(double(i) / along);
    const auto section = [&](double x, double z, double radius) {
        std::vector<gp_Pnt> points;
        for (double angle : angles)
            points.push_back(fuselage_point({x, 0, z}, radius, f.height_ratio, angle));
        return points;
    };
    const double barrel_end = f.length - f.tail_length;
    std::vector<std::vector<gp_Pnt>> nose, barrel, tail, end;
    for (double t : fractions) {
        nose.push_back(section(f.nose_length * (1 - std::cos(t * pi / 2)), 0,
                               f.radius * std::sin(t * pi / 2)));
        const double blend = t * t * (3 - 2 * t);
        tail.push_back(section(barrel_end + f.tail_length * t, f.tail_rise * blend,
                               f.radius + (f.tail_radius - f.radius) * blend));
        end.push_back(section(f.length + f.tail_radius * std::sin(t * pi / 2), f.tail_rise,
                              f.tail_radius * std::cos(t * pi / 2)));
    }
    barrel = {nose.back(), tail.front()};
    end.back() = section(f.length + f.tail_radius, f.tail_rise, 0);
    std::vector<TopoDS_Face> faces;
    for (const auto& sections : {nose, barrel, tail, end}) {
        const std::vector<double> v = sections.size() == 2 ? std::vector<double>{0, 1} : fractions;
        faces.push_back(face_of(part(loft(sections, angles, v), 0, pi, 0, 1)));
    }
    return faces;
}

TopoDS_Solid solid_of(const Nacelle& nacelle) {
    std::vector<std::vector<gp_Pnt>> rows(2);
    const std::vector<double> s = section_parameters();
    const Station station{nacelle.intake_centre.Translated(gp_Vec(0, 0, nacelle.radius)),
                          nacelle.length, 0, 0, nacelle.airfoil};
    for (double si : s) {
        rows[0].push_back(skin_point(station, si));
        rows[1].push_back(rows[0].back().Translated(gp_Vec(0, 1, 0)));
    }
    const Surface strip = loft(rows, s, {0, 1});
    const Curve upper = as_spline(part(strip, 0, 1, 0, 1)->VIso(0));
    const Curve lower = as_spline(part(strip, -1, 0, 0, 1)->VIso(0));
    BRepBuilderAPI_MakeWire wire(BRepBuilderAPI_MakeEdge(lower).Edge(),
                                 BRepBuilderAPI_MakeEdge(upper).Edge());
    if (nacelle.airfoil.base > 0)
        wire.Add(BRepBuilderAPI_MakeEdge(upper->EndPoint(), lower->StartPoint()).Edge());
    const TopoDS_Face section = BRepBuilderAPI_MakeFace(wire.Wire(), true).Face();
    const gp_Ax1 axis(nacelle.intake_centre, gp_Dir(1, 0, 0));
    TopoDS_Solid solid = TopoDS::Solid(BRepPrimAPI_MakeRevol(section, axis).Shape());
    BRepLib::OrientClosedSolid(solid);
    return solid;
}

}  // namespace aircraft
