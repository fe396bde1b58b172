// Writes the sample wing: a clean STEP solid, the same wing as a legacy IGES file, and a cage for
// it.
//
// Axes: x aft, y outboard, z up. Lengths in millimetres. The output is the same, byte for byte, on
// every run.

#include "make_sample_wing.h"

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepLib.hxx>
#include <GProp_GProps.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <GeomFill.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TCollection_HAsciiString.hxx>
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

using namespace sample_wing;

namespace {

constexpr double gap_mm = 2e-4 * 25.4;
const std::vector<double> span_stations{0, 0.15, 0.35, 0.55, 0.75, 0.9, 1};

Handle(Geom_BSplineCurve)
    interpolate(const std::vector<gp_Pnt>& points, const std::vector<double>& parameters) {
    const int n = static_cast<int>(points.size());
    Handle(TColgp_HArray1OfPnt) p = new TColgp_HArray1OfPnt(1, n);
    Handle(TColStd_HArray1OfReal) t = new TColStd_HArray1OfReal(1, n);
    for (int i = 0; i < n; ++i) {
        p->SetValue(i + 1, points[i]);
        t->SetValue(i + 1, parameters[i]);
    }
    GeomAPI_Interpolate interpolation(p, t, false, 1e-9);
    interpolation.Perform();
    if (!interpolation.IsDone()) throw std::runtime_error("interpolation failed");
    return interpolation.Curve();
}

/// Tensor product interpolation: along every section first, then every column of poles.
Handle(Geom_BSplineSurface) make_skin() {
    constexpr int side = 16;
    std::vector<double> s;
    for (int i = -side; i <= side; ++i) s.push_back(double(i) / side);
    std::vector<Handle(Geom_BSplineCurve)> sections;
    for (double eta : span_stations) {
        std::vector<gp_Pnt> points;
        for (double si : s) points.push_back(skin_point(si, eta));
        sections.push_back(interpolate(points, s));
    }
    const auto& u = sections.front();
    Handle(Geom_BSplineCurve) v;
    TColgp_Array2OfPnt poles(1, u->NbPoles(), 1, static_cast<int>(span_stations.size()) + 2);
    for (int i = 1; i <= u->NbPoles(); ++i) {
        std::vector<gp_Pnt> column;
        for (const auto& section : sections) column.push_back(section->Pole(i));
        v = interpolate(column, span_stations);
        for (int j = 1; j <= v->NbPoles(); ++j) poles.SetValue(i, j, v->Pole(j));
    }
    return new Geom_BSplineSurface(poles, u->Knots(), v->Knots(), u->Multiplicities(),
                                   v->Multiplicities(), 3, 3);
}

Handle(Geom_BSplineSurface)
    part(const Handle(Geom_BSplineSurface) & skin, double u0, double u1, double v0, double v1) {
    Handle(Geom_BSplineSurface) copy = Handle(Geom_BSplineSurface)::DownCast(skin->Copy());
    copy->Segment(u0, u1, v0, v1);
    return copy;
}

Handle(Geom_BSplineCurve) curve(const Handle(Geom_Curve) & c) {
    return Handle(Geom_BSplineCurve)::DownCast(c);
}

/// The rounded tip: half ellipses from the upper to the lower tip curve; one point at the nose.
Handle(Geom_BSplineSurface)
    make_cap(const Handle(Geom_BSplineCurve) & upper, const Handle(Geom_BSplineCurve) & lower) {
    // A unit half circle as two cubic Bezier arcs that meet C1: cosine and sine of the poles.
    const double k = 4.0 / 3 * (std::sqrt(2.0) - 1);
    const std::array<double, 6> cosine{1, 1, k, -k, -1, -1};
    const std::array<double, 6> sine{0, k, 1, 1, k, 0};
    const double nose = upper->Pole(1).X();
    const double chord = upper->Pole(upper->NbPoles()).X() - nose;
    TColgp_Array2OfPnt poles(1, upper->NbPoles(), 1, 6);
    for (int i = 1; i <= upper->NbPoles(); ++i) {
        const gp_XYZ a = upper->Pole(i).XYZ();
        const gp_XYZ b = lower->Pole(i).XYZ();
        const gp_XYZ middle = (a + b) / 2;
        const gp_XYZ half = (a - b) / 2;
        const double fraction = std::clamp((middle.X() - nose) / chord, 0.0, 1.0);
        const gp_XYZ out = span_direction(fraction).XYZ() * (cap_aspect * half.Z());
        for (int j = 1; j <= 6; ++j) {
            const gp_XYZ p = middle + half * cosine[j - 1] + out * sine[j - 1];
            poles.SetValue(i, j, j == 1 ? upper->Pole(i) : j == 6 ? lower->Pole(i) : gp_Pnt(p));
        }
    }
    TColStd_Array1OfReal knots(1, 3);
    TColStd_Array1OfInteger multiplicities(1, 3);
    for (int i = 1; i <= 3; ++i) {
        knots.SetValue(i, i - 1);
        multiplicities.SetValue(i, i == 2 ? 2 : 4);
    }
    return new Geom_BSplineSurface(poles, upper->Knots(), knots, upper->Multiplicities(),
                                   multiplicities, 3, 3);
}

TopoDS_Face planar_face(const std::vector<Handle(Geom_BSplineCurve)>& loop) {
    BRepBuilderAPI_MakeWire wire;
    for (const auto& c : loop) wire.Add(BRepBuilderAPI_MakeEdge(c).Edge());
    return BRepBuilderAPI_MakeFace(wire.Wire(), true).Face();
}

Handle(Geom_BSplineCurve) line(const gp_Pnt& a, const gp_Pnt& b) {
    TColgp_Array1OfPnt poles(1, 2);
    poles.SetValue(1, a);
    poles.SetValue(2, b);
    TColStd_Array1OfReal knots(1, 2);
    knots.SetValue(1, 0);
    knots.SetValue(2, 1);
    TColStd_Array1OfInteger multiplicities(1, 2);
    multiplicities.Init(2);
    return new Geom_BSplineCurve(poles, knots, multiplicities, 1);
}

struct WingFaces {
    std::vector<Handle(Geom_BSplineSurface)> free_form;  // natural boundaries, normals outward
    std::vector<TopoDS_Face> planar;
};

WingFaces make_wing() {
    const Handle(Geom_BSplineSurface) skin = make_skin();
    const double kink = 0.35;  // a knot: legacy files are split where the sections were defined
    WingFaces wing;
    for (const auto& [v0, v1] : {std::pair{0.0, kink}, std::pair{kink, 1.0}}) {
        const auto upper = part(skin, 0, 1, v0, v1);
        const auto lower = part(skin, -1, 0, v0, v1);
        wing.free_form.push_back(upper);
        wing.free_form.push_back(lower);
        wing.free_form.push_back(Handle(Geom_BSplineSurface)::DownCast(
            GeomFill::Surface(lower->UIso(-1), upper->UIso(1))));
    }
    const auto upper_tip = curve(part(skin, 0, 1, kink, 1)->VIso(1));
    const auto lower_tip = curve(part(skin, -1, 0, kink, 1)->VIso(1));
    lower_tip->Reverse();  // nose to trailing edge, like the upper one
    const auto cap = make_cap(upper_tip, lower_tip);
    wing.free_form.push_back(cap);
    wing.planar.push_back(
        planar_face({curve(cap->UIso(1)), line(lower_tip->EndPoint(), upper_tip->EndPoint())}));
    const auto upper_root = curve(part(skin, 0, 1, 0, kink)->VIso(0));
    const auto lower_root = curve(part(skin, -1, 0, 0, kink)->VIso(0));
    wing.planar.push_back(planar_face(
        {lower_root, upper_root, line(upper_root->EndPoint(), lower_root->StartPoint())}));
    return wing;
}

TopoDS_Solid sewn_solid(const WingFaces& wing) {
    BRepBuilderAPI_Sewing sewing(1e-5);
    for (const auto& surface : wing.free_form) {
        sewing.Add(BRepBuilderAPI_MakeFace(surface, 1e-7).Face());
    }
    for (const auto& face : wing.planar) sewing.Add(face);
    sewing.Perform();
    if (sewing.NbFreeEdges() != 0) throw std::runtime_error("the clean wing does not close");
    TopoDS_Solid solid = BRepBuilderAPI_MakeSolid(TopoDS::Shell(sewing.SewedShape())).Solid();
    BRepLib::OrientClosedSolid(solid);
    if (!BRepCheck_Analyzer(solid).IsValid())
        throw std::runtime_error("the clean wing is not valid");
    return solid;
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
        Handle(Geom_BSplineSurface) moved = Handle(Geom_BSplineSurface)::DownCast(surface->Copy());
        const gp_XYZ shift(random(), random(), random());
        const gp_XYZ stretch(random(), random(), random());
        for (int i = 1; i <= moved->NbUPoles(); ++i) {
            for (int j = 1; j <= moved->NbVPoles(); ++j) {
                const gp_XYZ p = moved->Pole(i, j).XYZ();
                moved->SetPole(i, j, p + (shift + stretch * (p.Y() / span_mm)) * gap_mm);
            }
        }
        if (faces.size() % 3 == 1) moved->UReverse();
        faces.push_back(BRepBuilderAPI_MakeFace(moved, 1e-7).Face());
    }
    for (const auto& face : wing.planar) {
        gp_Trsf move;
        move.SetTranslation(gp_Vec(random(), random(), random()) * gap_mm);
        faces.push_back(TopoDS::Face(BRepBuilderAPI_Transform(face, move, true).Shape()));
    }
    return faces;
}

void write_step(const TopoDS_Shape& shape, const std::string& path) {
    STEPControl_Controller::Init();
    Interface_Static::SetCVal("write.step.schema", "AP214IS");
    Interface_Static::SetCVal("write.step.unit", "MM");
    Interface_Static::SetCVal("write.step.product.name", "sample wing");
    STEPControl_Writer writer;
    if (writer.Transfer(shape, STEPControl_AsIs) != IFSelect_RetDone) {
        throw std::runtime_error(path + ": not translated");
    }
    const auto text = [](const char* s) { return new TCollection_HAsciiString(s); };
    APIHeaderSection_MakeHeader header(writer.Model());
    header.SetName(text("wing.step"));
    header.SetTimeStamp(text("2000-01-01T00:00:00"));
    header.SetAuthorValue(1, text("patchwright"));
    header.SetOrganizationValue(1, text("patchwright"));
    header.SetOriginatingSystem(text("make_sample_wing"));
    if (writer.Write(path.c_str()) != IFSelect_RetDone)
        throw std::runtime_error(path + ": not written");
}

void write_iges(const std::vector<TopoDS_Face>& faces, const std::string& path) {
    IGESControl_Controller::Init();
    IGESControl_Writer writer("IN", 0);  // 0: trimmed surfaces one by one, no B-rep
    for (const auto& face : faces) {
        if (!writer.AddShape(face)) throw std::runtime_error(path + ": a face is not translated");
    }
    const auto text = [](const char* s) { return new TCollection_HAsciiString(s); };
    IGESData_GlobalSection global = writer.Model()->GlobalSection();
    global.SetFileName(text("wing.igs"));
    global.SetSendName(text("sample wing"));
    global.SetSystemId(text("make_sample_wing"));
    global.SetAuthorName(text("patchwright"));
    global.SetDate(text("20000101.000000"));
    global.SetLastChangeDate(text("20000101.000000"));
    writer.Model()->SetGlobalSection(global);
    writer.ComputeModel();
    if (!writer.Write(path.c_str())) throw std::runtime_error(path + ": not written");
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: make_sample_wing FOLDER\n");
        return 1;
    }
    try {
        Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));  // chatter
        const std::filesystem::path folder = argv[1];
        std::filesystem::create_directories(folder);
        const WingFaces wing = make_wing();
        const TopoDS_Solid solid = sewn_solid(wing);
        GProp_GProps volume, area;
        BRepGProp::VolumeProperties(solid, volume);
        BRepGProp::SurfaceProperties(solid, area);
        write_step(solid, folder / "wing.step");
        write_iges(legacy_faces(wing), folder / "wing.igs");
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
