#include "make_aircraft.h"

#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBndLib.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRep_Builder.hxx>
#include <Bnd_Box.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace aircraft {

namespace {

constexpr double deg = std::numbers::pi / 180;

double mix(double a, double b, double t) { return a + (b - a) * t; }

Airfoil mix(const Airfoil& a, const Airfoil& b, double t) {
    Airfoil result;
    for (std::size_t i = 0; i < 4; ++i) {
        result.upper[i] = mix(a.upper[i], b.upper[i], t);
        result.lower[i] = mix(a.lower[i], b.lower[i], t);
    }
    result.base = mix(a.base, b.base, t);
    return result;
}

Station mix(const Station& a, const Station& b, double t) {
    return {a.nose.XYZ() * (1 - t) + b.nose.XYZ() * t, mix(a.chord, b.chord, t),
            mix(a.twist, b.twist, t), mix(a.roll, b.roll, t), mix(a.airfoil, b.airfoil, t)};
}

/// A straight wing panel: from its root outboard by `span` along its dihedral.
struct Planform {
    double span = 0.0, tip_chord = 0.0, sweep = 0.0, dihedral = 0.0, washout = 0.0;
};

Station tip_of(const Station& root, const Planform& form, const Airfoil& airfoil) {
    const gp_Vec along(std::tan(form.sweep), std::cos(form.dihedral), std::sin(form.dihedral));
    return {root.nose.Translated(along * form.span), form.tip_chord, root.twist - form.washout,
            form.dihedral, airfoil};
}

TopoDS_Shape fused(const std::vector<TopoDS_Shape>& solids) {
    TopTools_ListOfShape first, others;
    first.Append(solids.front());
    for (std::size_t i = 1; i < solids.size(); ++i) others.Append(solids[i]);
    BRepAlgoAPI_Fuse fuse;
    fuse.SetArguments(first);
    fuse.SetTools(others);
    fuse.Build();
    TopTools_IndexedMapOfShape found;
    TopExp::MapShapes(fuse.Shape(), TopAbs_SOLID, found);
    if (found.Extent() != 1 || !BRepCheck_Analyzer(found(1)).IsValid())
        throw std::runtime_error("the seed's parts do not make one valid solid");
    return found(1);
}

/// What lies at y > 0, as a shell that is open at y = 0.
TopoDS_Shape right_half(const TopoDS_Shape& solid) {
    Bnd_Box box;
    BRepBndLib::Add(solid, box);
    const gp_Pnt low = box.CornerMin(), high = box.CornerMax();
    constexpr double margin_mm = 100;
    const gp_Pnt from(low.X() - margin_mm, 0, low.Z() - margin_mm);
    const TopoDS_Shape half = BRepAlgoAPI_Common(
        solid, BRepPrimAPI_MakeBox(from, high.Translated(gp_Vec(1, 1, 1) * margin_mm)).Solid());
    TopTools_IndexedMapOfShape faces;
    TopExp::MapShapes(half, TopAbs_FACE, faces);
    std::vector<TopoDS_Face> kept;
    constexpr double plane_mm = 1e-3;
    for (int i = 1; i <= faces.Extent(); ++i) {
        Bnd_Box extent;
        BRepBndLib::AddOptimal(faces(i), extent, false, false);
        if (extent.CornerMax().Y() > plane_mm) kept.push_back(TopoDS::Face(faces(i)));
    }
    return lofts::sewn(kept);
}

TopoDS_Shape untrimmed(const std::vector<TopoDS_Face>& right, Extent extent) {
    if (extent == Extent::OpenHalf) return lofts::sewn(right);
    return lofts::sewn_solid(with_mirror_image(right));
}

/// `whole` and both of each of the parts beside the plane of symmetry.
TopoDS_Shape assembled(std::vector<TopoDS_Shape> whole, const std::vector<TopoDS_Shape>& right,
                       Extent extent) {
    for (const TopoDS_Shape& part : right) {
        whole.push_back(part);
        whole.push_back(mirror_image(part));
    }
    const TopoDS_Shape solid = fused(whole);
    return extent == Extent::Whole ? solid : right_half(solid);
}

TopoDS_Shape closed_wing(std::vector<std::vector<Station>> panels, Tip tip) {
    return lofts::sewn_solid(
        faces_of(Wing{.panels = std::move(panels), .tip = tip, .closed_root = true}));
}

class Maker {
  public:
    Maker(unsigned seed, Borders borders, Extent extent)
        : random_(seed), borders_(borders), extent_(extent) {
        // By the seed itself: a few seeds have all of them.
        shape_ = int(seed % 3);
        base_ = seed % 2 == 0 ? between(0.002, 0.006) : 0.0;
        tip_ = seed / 2 % 2 == 0 ? Tip::Rounded : Tip::Plane;
    }

    TopoDS_Shape flying_wing() {
        const double span = between(4000, 9000);
        const Airfoil root_airfoil = airfoil(between(0.13, 0.17));
        const Airfoil tip_airfoil = airfoil(between(0.09, 0.12));
        const bool trimmed = borders_ == Borders::Trimmed;
        const double sweep = between(20, 38) * deg, dihedral = between(0, 4) * deg;
        // Fins stand on sections that are level.
        const double washout = trimmed ? 0.0 : between(0, 4) * deg;
        const Station root{gp_Pnt(0, 0, 0), span * between(0.35, 0.55), 0, 0, root_airfoil};
        const double tip_chord = root.chord * between(0.3, 0.45);
        Wing wing{.tip = tip_};
        Station inner = root;
        if (chance()) {  // a crank
            const double at = between(0.25, 0.4);
            const double chord = mix(root.chord, tip_chord, at) * between(0.9, 1.0);
            inner =
                tip_of(root, {at * span, chord, sweep * between(0.8, 1.2), dihedral, at * washout},
                       mix(root_airfoil, tip_airfoil, at));
            wing.panels.push_back({root, inner});
        }
        const double left = span - inner.nose.Y();
        const Station tip =
            tip_of(inner, {left, tip_chord, sweep, dihedral, washout + inner.twist}, tip_airfoil);
        wing.panels.push_back({inner, tip});
        if (!trimmed) {
            add_winglet(wing, span);
            return untrimmed(faces_of(wing), extent_);
        }
        const TopoDS_Shape fin = fin_on(mix(inner, tip, between(0.85, 0.95)), 0.7 * tip_chord);
        return assembled({lofts::sewn_solid(with_mirror_image(faces_of(wing)))}, {fin}, extent_);
    }

    TopoDS_Shape blended_wing_body() {
        const double span = between(9000, 16000);
        const double root_chord = span * between(0.7, 0.9), tip_chord = span * between(0.08, 0.12);
        const double sweep = between(28, 38) * deg, dihedral = between(0, 4) * deg;
        const double body_width = between(0.2, 0.28);  // of the half span
        const Airfoil middle = airfoil(between(0.14, 0.17)), outer = airfoil(between(0.09, 0.11));
        std::vector<Station> stations;
        for (const double at : {0.0, 0.06, 0.13, 0.21, 0.3, 0.4, 0.52, 0.68, 0.84, 1.0}) {
            const double body = 1 / (1 + std::pow(at / body_width, 3));
            const double wing_chord = mix(2.6 * tip_chord, tip_chord, at);
            // Rounded in the middle, where its mirror image joins.
            const double x = span * std::tan(sweep) * (std::hypot(at, 0.1) - 0.1);
            stations.push_back({gp_Pnt(x, at * span, span * std::tan(dihedral) * at * at),
                                mix(wing_chord, root_chord, body), 0.0, 0.0,
                                mix(outer, middle, body)});
        }
        Wing wing{.panels = {stations}, .smooth_root = true, .tip = tip_};
        if (borders_ == Borders::Untrimmed) {
            if (chance()) add_winglet(wing, span);
            return untrimmed(faces_of(wing), extent_);
        }
        const TopoDS_Shape fin = fin_on(stations[4], 0.4 * stations[4].chord);
        return assembled({lofts::sewn_solid(with_mirror_image(faces_of(wing)))}, {fin}, extent_);
    }

    TopoDS_Shape wing_body_tails() {
        require_trimmed("wing_body_tails");
        const Fuselage body = fuselage();
        const Tails tails = tails_of(body);
        return assembled(
            {lofts::sewn_solid(with_mirror_image(faces_of(body))),
             closed_wing({{tails.fin_root, tails.fin_tip}}, tip_)},
            {closed_wing(main_wing(body), tip_), closed_wing({{tails.root, tails.tip}}, tip_)},
            extent_);
    }

    /// Solids of their own, as tools for early design write them: halves of wing and tail planes
    /// touch in ribs in the plane of symmetry, and run through the body.
    TopoDS_Shape components() {
        require_trimmed("components");
        if (extent_ != Extent::Whole)
            throw std::invalid_argument("components are made on both sides only");
        const Fuselage body = fuselage();
        const Tails tails = tails_of(body);
        std::vector<TopoDS_Shape> parts{lofts::sewn_solid(with_mirror_image(faces_of(body))),
                                        closed_wing({{tails.fin_root, tails.fin_tip}}, tip_)};
        for (const auto& panels :
             {main_wing(body), std::vector<std::vector<Station>>{{tails.root, tails.tip}}}) {
            parts.push_back(closed_wing(at_symmetry_plane(panels), tip_));
            parts.push_back(mirror_image(parts.back()));
        }
        const BRep_Builder builder;
        TopoDS_Compound all;
        builder.MakeCompound(all);
        for (const TopoDS_Shape& part : parts) builder.Add(all, part);
        return all;
    }

    TopoDS_Shape wing_body_nacelles() {
        require_trimmed("wing_body_nacelles");
        const Fuselage body = fuselage();
        const auto panels = main_wing(body);
        const Station at = mix(panels.back().front(), panels.back().back(), between(0.2, 0.35));
        Nacelle nacelle{.radius = body.length * between(0.027, 0.034),
                        .length = body.length * between(0.11, 0.14),
                        .airfoil = airfoil(between(0.11, 0.14))};
        const double depth = nacelle.radius + body.length * between(0.018, 0.025);
        nacelle.intake_centre =
            at.nose.Translated(gp_Vec(-between(0.45, 0.6) * nacelle.length, 0, -depth));
        const Airfoil thin = symmetric_airfoil(between(0.07, 0.09));
        const gp_Vec to_wall(0.25 * nacelle.length, 0, nacelle.radius);
        const Station foot{nacelle.intake_centre.Translated(to_wall), 0.55 * nacelle.length, 0,
                           90 * deg, thin};
        const gp_Vec to_wing(0.1 * at.chord, 0, 0.012 * at.chord);
        const Station head{at.nose.Translated(to_wing), 0.5 * at.chord, 0, 90 * deg, thin};
        return assembled(
            {lofts::sewn_solid(with_mirror_image(faces_of(body)))},
            {closed_wing(panels, tip_), solid_of(nacelle), closed_wing({{foot, head}}, Tip::Plane)},
            extent_);
    }

  private:
    // std::uniform_real_distribution differs between libraries.
    double between(double low, double high) {
        return low + (high - low) * double(random_() % 100000u) / 1e5;
    }
    bool chance() { return random_() % 2 == 0; }

    void require_trimmed(const char* kind) const {
        if (borders_ == Borders::Untrimmed)
            throw std::invalid_argument(std::string(kind) + " is made with trimmed borders only");
    }

    /// Symmetric, cambered or loaded aft, as the seed says.
    Airfoil airfoil(double thickness) const {
        constexpr std::array<std::array<double, 4>, 3> upper{
            {{1, 1, 1, 1}, {1, 1.25, 1.3, 1.2}, {1, 1.1, 1.2, 1.2}}};
        constexpr std::array<std::array<double, 4>, 3> lower{
            {{1, 1, 1, 1}, {1, 0.75, 0.7, 0.6}, {1, 0.9, 0.9, -0.2}}};
        return scaled(upper[std::size_t(shape_)], lower[std::size_t(shape_)], thickness);
    }

    Airfoil symmetric_airfoil(double thickness) const {
        return scaled({1, 1, 1, 1}, {1, 1, 1, 1}, thickness);
    }

    Airfoil scaled(std::array<double, 4> upper, std::array<double, 4> lower,
                   double thickness) const {
        constexpr double unit_thickness = 0.7698;  // of coefficients 1: 4 / 27^(1/2)
        for (double& a : upper) a *= thickness / unit_thickness;
        for (double& a : lower) a *= thickness / unit_thickness;
        return {upper, lower, base_};
    }

    /// Along an arc, or at an angle.
    void add_winglet(Wing& wing, double span) {
        const Station tip = wing.panels.back().back();
        const double cant = between(60, 88) * deg, sweep = between(30, 45) * deg;
        const Airfoil thin = symmetric_airfoil(between(0.08, 0.1));
        Station start = tip;
        if (chance()) {
            const double radius = span * between(0.03, 0.06);
            std::vector<Station> bend;
            constexpr int steps = 6;
            for (int i = 0; i <= steps; ++i) {
                const double t = double(i) / steps, roll = mix(tip.roll, cant, t);
                const double length = radius * (roll - tip.roll);
                const gp_Vec along(length * std::tan(sweep),
                                   radius * (std::sin(roll) - std::sin(tip.roll)),
                                   radius * (std::cos(tip.roll) - std::cos(roll)));
                bend.push_back({tip.nose.Translated(along), tip.chord * mix(1, 0.75, t), tip.twist,
                                roll, mix(tip.airfoil, thin, t)});
            }
            wing.panels.push_back(bend);
            start = bend.back();
        } else {
            // The mitre: half the turn, and sections that are as much thicker as it cuts askew.
            Station& mitre = wing.panels.back().back();
            mitre.roll = (tip.roll + cant) / 2;
            const double stretch = 1 / std::cos((cant - tip.roll) / 2);
            for (double& a : mitre.airfoil.upper) a *= stretch;
            for (double& a : mitre.airfoil.lower) a *= stretch;
            mitre.airfoil.base *= stretch;
            start = mitre;
        }
        Planform form{span * between(0.1, 0.16), start.chord * between(0.45, 0.65), sweep, cant};
        wing.panels.push_back({start, tip_of(start, form, thin)});
    }

    /// A fin that stands on a wing at a station; its root is inside of the wing.
    TopoDS_Shape fin_on(const Station& at, double chord) {
        const Airfoil thin = symmetric_airfoil(between(0.08, 0.1));
        const gp_Vec inside(0.8 * at.chord - chord, 0, 0.012 * at.chord);
        const double cant = between(70, 90) * deg;
        const Station root{at.nose.Translated(inside), chord, 0, cant, thin};
        const Planform form{chord * between(0.8, 1.4), chord * between(0.4, 0.6),
                            between(25, 45) * deg, cant};
        return closed_wing({{root, tip_of(root, form, thin)}}, tip_);
    }

    struct Tails {
        Station root, tip, fin_root, fin_tip;
    };

    Tails tails_of(const Fuselage& body) {
        const double r = body.radius;
        const Airfoil thin = symmetric_airfoil(between(0.08, 0.1));
        const double chord = body.length * between(0.07, 0.09);
        const double sweep = between(15, 40) * deg;
        Tails tails;
        tails.root = {gp_Pnt(0.86 * body.length, 0.1 * r, 0.42 * r), chord, 0, 0, thin};
        tails.tip = tip_of(tails.root,
                           {body.length * between(0.14, 0.18), chord * between(0.4, 0.6), sweep,
                            between(0, 8) * deg},
                           thin);
        tails.fin_root = {gp_Pnt(0.82 * body.length, 0, 0.45 * r), 1.3 * chord, 0, 90 * deg, thin};
        tails.fin_tip =
            tip_of(tails.fin_root,
                   {body.length * between(0.12, 0.16), 0.6 * chord, sweep, 90 * deg}, thin);
        return tails;
    }

    static std::vector<std::vector<Station>> at_symmetry_plane(
        std::vector<std::vector<Station>> panels) {
        const gp_Vec inboard(0, -panels.front().front().nose.Y(), 0);
        for (auto& panel : panels)
            for (Station& station : panel) station.nose.Translate(inboard);
        return panels;
    }

    Fuselage fuselage() {
        Fuselage body{.length = between(15000, 40000)};
        body.radius = body.length * between(0.05, 0.06);
        body.nose_length = body.radius * between(1.5, 3);
        body.tail_length = body.length * between(0.3, 0.34);
        body.tail_radius = body.radius * between(0.12, 0.18);
        body.tail_rise = 0.5 * body.radius;
        body.height_ratio = between(1.0, 1.1);
        return body;
    }

    /// Low or in the middle; its root is inside of the fuselage.
    std::vector<std::vector<Station>> main_wing(const Fuselage& body) {
        const double span = body.length * between(0.4, 0.48);
        const double height = chance() ? -0.45 : -0.05;
        const double sweep = between(5, 32) * deg, dihedral = between(1, 6) * deg;
        const double root_chord = body.length * between(0.15, 0.19);
        const double tip_chord = root_chord * between(0.25, 0.45);
        const Airfoil thick = airfoil(between(0.12, 0.14)), thin = airfoil(between(0.09, 0.11));
        const gp_Pnt nose(body.length * between(0.33, 0.38), 0.4 * body.radius,
                          height * body.radius);
        const Station root{nose, root_chord, between(0, 3) * deg, 0, thick};
        if (!chance()) return {{root, tip_of(root, {span, tip_chord, sweep, dihedral}, thin)}};
        const double at = between(0.3, 0.4);
        const Planform inner{at * span, root_chord * between(0.62, 0.7), sweep, dihedral};
        const Station crank = tip_of(root, inner, mix(thick, thin, 0.7));
        const Planform outer{(1 - at) * span, tip_chord, sweep, dihedral};
        return {{root, crank}, {crank, tip_of(crank, outer, thin)}};
    }

    std::mt19937 random_;
    Borders borders_;
    Extent extent_;
    int shape_ = 0;      ///< of airfoils
    double base_ = 0.0;  ///< of airfoils
    Tip tip_ = Tip::Plane;
};

}  // namespace

TopoDS_Shape make_aircraft(const std::string& kind, unsigned seed, Borders borders, Extent extent) {
    Maker maker(seed, borders, extent);
    if (kind == "flying_wing") return maker.flying_wing();
    if (kind == "blended_wing_body") return maker.blended_wing_body();
    if (kind == "wing_body_tails") return maker.wing_body_tails();
    if (kind == "wing_body_nacelles") return maker.wing_body_nacelles();
    if (kind == "components") return maker.components();
    throw std::invalid_argument("there is no kind " + kind);
}

}  // namespace aircraft
