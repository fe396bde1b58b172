// Writes the sample wing: a clean STEP solid, the same wing as a legacy IGES file, and a cage for
// it.
//
// Axes: x aft, y outboard, z up. Lengths in millimetres. The output is the same, byte for byte, on
// every run.

#include "make_sample_wing.h"

#include "make_files.h"
#include "make_lofts.h"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepGProp.hxx>
#include <GProp_GProps.hxx>
#include <Standard_Failure.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Solid.hxx>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

using namespace lofts;
using namespace sample_wing;

namespace {

constexpr double gap_mm = 2e-4 * 25.4;
const std::vector<double> span_stations{0, 0.15, 0.35, 0.55, 0.75, 0.9, 1};

Surface make_skin(const WingShape& shape) {
    constexpr int side = 16;
    std::vector<double> s;
    for (int i = -side; i <= side; ++i) s.push_back(double(i) / side);
    std::vector<std::vector<gp_Pnt>> sections;
    for (double eta : span_stations) {
        sections.emplace_back();
        for (double si : s) sections.back().push_back(skin_point(si, eta, shape));
    }
    return loft(sections, s, span_stations);
}

/// The rounded tip; one point at the nose.
Surface make_cap(const Curve& upper, const Curve& lower, const WingShape& shape) {
    const double nose = upper->Pole(1).X();
    const double chord = upper->Pole(upper->NbPoles()).X() - nose;
    return rounded_cap(upper, lower, [&](const gp_XYZ& centre, const gp_XYZ& half) {
        const double fraction = std::clamp((centre.X() - nose) / chord, 0.0, 1.0);
        return span_direction(fraction, shape).XYZ() * (cap_aspect * half.Z());
    });
}

TopoDS_Face planar_face(const std::vector<Curve>& loop) {
    BRepBuilderAPI_MakeWire wire;
    for (const auto& c : loop) wire.Add(BRepBuilderAPI_MakeEdge(c).Edge());
    return BRepBuilderAPI_MakeFace(wire.Wire(), true).Face();
}

struct WingFaces {
    std::vector<Surface> free_form;  // natural boundaries, normals outward
    std::vector<TopoDS_Face> planar;
};

WingFaces make_wing(const WingShape& shape = {}) {
    const Surface skin = make_skin(shape);
    const double kink = 0.35;  // a knot: legacy files are split where the sections were defined
    WingFaces wing;
    for (const auto& [v0, v1] : {std::pair{0.0, kink}, std::pair{kink, 1.0}}) {
        const auto upper = part(skin, 0, 1, v0, v1);
        const auto lower = part(skin, -1, 0, v0, v1);
        wing.free_form.push_back(upper);
        wing.free_form.push_back(lower);
        wing.free_form.push_back(ruled(as_spline(lower->UIso(-1)), as_spline(upper->UIso(1))));
    }
    const auto upper_tip = as_spline(part(skin, 0, 1, kink, 1)->VIso(1));
    const auto lower_tip = as_spline(part(skin, -1, 0, kink, 1)->VIso(1));
    lower_tip->Reverse();  // nose to trailing edge, like the upper one
    const auto cap = make_cap(upper_tip, lower_tip, shape);
    wing.free_form.push_back(cap);
    wing.planar.push_back(
        planar_face({as_spline(cap->UIso(1)), line(lower_tip->EndPoint(), upper_tip->EndPoint())}));
    const auto upper_root = as_spline(part(skin, 0, 1, 0, kink)->VIso(0));
    const auto lower_root = as_spline(part(skin, -1, 0, 0, kink)->VIso(0));
    wing.planar.push_back(planar_face(
        {lower_root, upper_root, line(upper_root->EndPoint(), lower_root->StartPoint())}));
    return wing;
}

std::vector<TopoDS_Face> all_faces(const WingFaces& wing) {
    std::vector<TopoDS_Face> faces;
    for (const Surface& surface : wing.free_form) faces.push_back(face_of(surface));
    faces.insert(faces.end(), wing.planar.begin(), wing.planar.end());
    return faces;
}

/// The faces as another system might have left them: each moved and stretched a little by itself,
/// and some turned inside out.
std::vector<TopoDS_Face> legacy_faces(const WingFaces& wing) {
    std::uint32_t state = 2412;
    const auto random = [&] {  // Numerical Recipes' generator: the same everywhere
        state = 1664525u * state + 1013904223u;
        return 2.0 * (state >> 8) / double(1u << 24) - 1;
    };
    std::vector<TopoDS_Face> faces;
    for (const auto& surface : wing.free_form) {
        Surface moved = Surface::DownCast(surface->Copy());
        const gp_XYZ shift(random(), random(), random());
        const gp_XYZ stretch(random(), random(), random());
        for (int i = 1; i <= moved->NbUPoles(); ++i) {
            for (int j = 1; j <= moved->NbVPoles(); ++j) {
                const gp_XYZ p = moved->Pole(i, j).XYZ();
                moved->SetPole(i, j,
                               p + (shift + stretch * (p.Y() / WingShape().span_mm)) * gap_mm);
            }
        }
        if (faces.size() % 3 == 1) moved->UReverse();
        faces.push_back(face_of(moved));
    }
    for (const auto& face : wing.planar) {
        gp_Trsf move;
        move.SetTranslation(gp_Vec(random(), random(), random()) * gap_mm);
        faces.push_back(TopoDS::Face(BRepBuilderAPI_Transform(face, move, true).Shape()));
    }
    return faces;
}

/// What words like bend=50 change.
/// @throw runtime_error when a word is none of these
WingShape variant(const std::vector<std::string>& words) {
    WingShape shape;
    for (const std::string& word : words) {
        const auto mark = word.find('=');
        const std::string name = word.substr(0, mark);
        const double value = mark == std::string::npos ? NAN : std::stod(word.substr(mark + 1));
        if (std::isnan(value)) throw std::runtime_error(word + ": is not NAME=NUMBER");
        if (name == "bend")
            shape.tip_bend_mm = value;
        else if (name == "twist")
            shape.tip_twist_deg = value;
        else if (name == "thickness")
            shape.thickness *= value;
        else if (name == "sweep")
            shape.sweep *= value;
        else if (name == "span")
            shape.span_mm *= value;
        else
            throw std::runtime_error(name + ": none of bend, twist, thickness, sweep, span");
    }
    return shape;
}

void write_variant(const std::filesystem::path& file, const WingShape& shape) {
    cad_files::write_step(sewn_solid(all_faces(make_wing(shape))), file,
                          {file.filename().string(), "sample wing", "make_sample_wing"});
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr,
                     "usage: make_sample_wing FOLDER\n"
                     "       make_sample_wing FILE.step [bend=MM] [twist=DEGREES] "
                     "[thickness=FACTOR] [sweep=FACTOR] [span=FACTOR]\n");
        return 1;
    }
    try {
        cad_files::silence_kernel();
        const std::filesystem::path folder = argv[1];
        if (folder.extension() == ".step") {
            write_variant(folder, variant({argv + 2, argv + argc}));
            return 0;
        }
        std::filesystem::create_directories(folder);
        const WingFaces wing = make_wing();
        const TopoDS_Solid solid = sewn_solid(all_faces(wing));
        GProp_GProps volume, area;
        BRepGProp::VolumeProperties(solid, volume);
        BRepGProp::SurfaceProperties(solid, area);
        cad_files::write_step(solid, folder / "wing.step",
                              {"wing.step", "sample wing", "make_sample_wing"});
        cad_files::write_iges(legacy_faces(wing), folder / "wing.igs",
                              {"wing.igs", "sample wing", "make_sample_wing"}, "IN");
        write_cage(folder / "wing_cage.obj");
        std::printf("%zu faces, %.6g mm3, %.6g mm2\n", wing.free_form.size() + wing.planar.size(),
                    volume.Mass(), area.Mass());
    } catch (const Standard_Failure& failure) {
        std::fprintf(stderr, "make_sample_wing: %s\n", failure.GetMessageString());
        return 5;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "make_sample_wing: %s\n", error.what());
        return 5;
    }
}
