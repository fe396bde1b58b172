// Writes seeded random parts as BREP files: boxes and cylinders to which boxes, cylinders, cones,
// tori and lofts are added or cut out, some edges rounded.
//
// Usage: make_random_parts FOLDER COUNT [FIRST_SEED]
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <gp_Ax2.hxx>
#include <gp_Vec.hxx>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <random>
#include <string>

namespace {

class PartMaker {
  public:
    explicit PartMaker(unsigned seed) : random_(seed) {}

    std::optional<TopoDS_Shape> make() {
        TopoDS_Shape part = between(0.0, 1.0) < 0.6 ? box(60.0, 100.0) : cylinder(25.0, 45.0);
        const int steps = 2 + int(random_() % 3);
        for (int i = 0; i < steps; ++i) {
            const TopoDS_Shape tool = primitive();
            TopoDS_Shape next;
            if (random_() % 2 == 0) {
                next = BRepAlgoAPI_Fuse(part, tool).Shape();
            } else {
                next = BRepAlgoAPI_Cut(part, tool).Shape();
            }
            if (usable(next)) part = next;
        }
        if (random_() % 2 == 0) {
            const TopoDS_Shape rounded = fillets(part);
            if (usable(rounded)) part = rounded;
        }
        if (!usable(part)) return std::nullopt;
        return part;
    }

  private:
    // std::uniform_real_distribution differs between libraries.
    double between(double low, double high) {
        return low + (high - low) * double(random_() % 100000u) / 1e5;
    }

    gp_Ax2 frame() {
        const std::array<gp_Dir, 6> directions{gp_Dir(1, 0, 0),  gp_Dir(0, 1, 0), gp_Dir(0, 0, 1),
                                               gp_Dir(0, 0, -1), gp_Dir(1, 1, 0), gp_Dir(0, 1, 1)};
        return {gp_Pnt(between(-30, 30), between(-30, 30), between(-30, 30)),
                directions[random_() % directions.size()]};
    }

    TopoDS_Shape box(double low, double high) {
        const double a = between(low, high), b = between(low, high), c = between(low, high);
        return BRepPrimAPI_MakeBox(gp_Pnt(-a / 2, -b / 2, -c / 2), a, b, c).Shape();
    }

    TopoDS_Shape cylinder(double low, double high) {
        const double radius = between(low, high), height = between(60.0, 120.0);
        return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, -height / 2), gp_Dir(0, 0, 1)), radius,
                                        height)
            .Shape();
    }

    TopoDS_Shape primitive() {
        switch (random_() % 5) {
            case 0:
                return BRepPrimAPI_MakeBox(frame(), between(20, 50), between(20, 50),
                                           between(30, 90))
                    .Shape();
            case 1:
                return BRepPrimAPI_MakeCylinder(frame(), between(8, 20), between(50, 150)).Shape();
            case 2:
                return BRepPrimAPI_MakeCone(frame(), between(12, 25), between(4, 10),
                                            between(40, 80))
                    .Shape();
            case 3: return loft();
            default: return BRepPrimAPI_MakeTorus(frame(), between(20, 35), between(5, 12)).Shape();
        }
    }

    /// Through three quadrilaterals, each turned against the last: twisted smooth sides.
    TopoDS_Shape loft() {
        const gp_Ax2 axes = frame();
        const double step = between(15, 30);
        double turn = between(0, 1);
        BRepOffsetAPI_ThruSections through(true);
        for (int i = 0; i < 3; ++i) {
            BRepBuilderAPI_MakePolygon section;
            const double a = between(10, 20), b = between(10, 20);
            turn += between(0.1, 0.4);
            for (int k = 0; k < 4; ++k) {
                const double x = k == 0 || k == 3 ? a : -a, y = k < 2 ? b : -b;
                const gp_Vec at =
                    gp_Vec(axes.XDirection()) * (x * std::cos(turn) - y * std::sin(turn)) +
                    gp_Vec(axes.YDirection()) * (x * std::sin(turn) + y * std::cos(turn)) +
                    gp_Vec(axes.Direction()) * (step * i);
                section.Add(axes.Location().Translated(at));
            }
            section.Close();
            through.AddWire(section.Wire());
        }
        through.Build();
        return through.Shape();
    }

    TopoDS_Shape fillets(const TopoDS_Shape& part) {
        try {
            BRepFilletAPI_MakeFillet fillet(part);
            TopTools_IndexedMapOfShape edges;
            TopExp::MapShapes(part, TopAbs_EDGE, edges);
            for (int i = 0; i < 3; ++i)
                fillet.Add(between(3, 6),
                           TopoDS::Edge(edges(1 + int(random_() % unsigned(edges.Extent())))));
            fillet.Build();
            return fillet.IsDone() ? fillet.Shape() : TopoDS_Shape();
        } catch (const Standard_Failure&) {
            return {};
        }
    }

    static bool usable(const TopoDS_Shape& shape) {
        if (shape.IsNull() || !BRepCheck_Analyzer(shape).IsValid()) return false;
        TopTools_IndexedMapOfShape solids;
        TopExp::MapShapes(shape, TopAbs_SOLID, solids);
        return solids.Extent() == 1;
    }

    std::mt19937 random_;
};

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: make_random_parts FOLDER COUNT [FIRST_SEED]\n");
        return 1;
    }
    const std::filesystem::path folder = argv[1];
    const int count = std::stoi(argv[2]);
    unsigned seed = argc > 3 ? unsigned(std::stoul(argv[3])) : 1;
    std::filesystem::create_directories(folder);
    for (int made = 0; made < count; ++seed) {
        const auto part = PartMaker(seed).make();
        if (!part) continue;
        char name[32];
        std::snprintf(name, sizeof name, "part_%03u.brep", seed);
        if (!BRepTools::Write(*part, (folder / name).c_str())) return 1;
        ++made;
    }
    return 0;
}
