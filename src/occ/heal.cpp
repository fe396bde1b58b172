#include "occ/heal.h"

#include "occ/cad_model_impl.h"

#include <patchwright/occ/inspect.h>

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <ShapeFix_Shell.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <fmt/format.h>

#include <array>
#include <vector>

namespace patchwright::occ {

namespace {

/// Tolerances to try, as fractions of the diagonal.
constexpr std::array sewing_steps{1e-7, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2};

double diagonal_of(const TopoDS_Shape& shape) {
    Bnd_Box box;
    BRepBndLib::Add(shape, box, false);
    return box.IsVoid() ? 0.0 : box.CornerMin().Distance(box.CornerMax());
}

int count_faces(const TopoDS_Shape& shape) {
    TopTools_IndexedMapOfShape map;
    TopExp::MapShapes(shape, TopAbs_FACE, map);
    return map.Extent();
}

TopoDS_Shape compound_of(const std::vector<TopoDS_Shape>& shapes) {
    if (shapes.size() == 1) return shapes.front();
    BRep_Builder builder;
    TopoDS_Compound compound;
    builder.MakeCompound(compound);
    for (const TopoDS_Shape& shape : shapes)
        builder.Add(compound, shape);
    return compound;
}

/// Solids, then shells outside solids, then faces outside shells.
struct Bodies {
    std::vector<TopoDS_Shape> solids, shells, faces;

    explicit Bodies(const TopoDS_Shape& shape) {
        for (TopExp_Explorer it(shape, TopAbs_SOLID); it.More(); it.Next())
            solids.push_back(it.Current());
        for (TopExp_Explorer it(shape, TopAbs_SHELL, TopAbs_SOLID); it.More(); it.Next()) {
            shells.push_back(it.Current());
        }
        for (TopExp_Explorer it(shape, TopAbs_FACE, TopAbs_SHELL); it.More(); it.Next()) {
            faces.push_back(it.Current());
        }
    }
};

struct Sewn {
    TopoDS_Shape shape;
    double tolerance = 0.0;
    int free_edges = 0;
};

/// Empty shape when this tolerance swallowed faces or joined more than two.
Sewn sew(const std::vector<TopoDS_Shape>& parts, double tolerance) {
    BRepBuilderAPI_Sewing sewing(tolerance);
    int faces = 0;
    for (const TopoDS_Shape& part : parts) {
        sewing.Add(part);
        faces += count_faces(part);
    }
    sewing.Perform();
    Sewn result{sewing.SewedShape(), tolerance, 0};
    if (result.shape.IsNull() || count_faces(result.shape) != faces ||
        sewing.NbMultipleEdges() > 0) {
        result.shape.Nullify();
        return result;
    }
    result.free_edges = count_free_edges(result.shape);
    return result;
}

Sewn sew_best(const std::vector<TopoDS_Shape>& parts, double diagonal, double max_tolerance_rel) {
    Sewn best;
    for (const double step : sewing_steps) {
        if (step > max_tolerance_rel * (1.0 + 1e-12)) break;
        Sewn tried = sew(parts, step * diagonal);
        if (tried.shape.IsNull()) continue;
        if (best.shape.IsNull() || tried.free_edges < best.free_edges) best = std::move(tried);
        if (best.free_edges == 0) break;
    }
    return best;
}

/// Faces of a shell agree in orientation afterwards; a shell that cannot is split by the kernel.
std::vector<TopoDS_Shape> oriented_shells(const TopoDS_Shape& shape) {
    std::vector<TopoDS_Shape> shells;
    for (TopExp_Explorer it(shape, TopAbs_SHELL); it.More(); it.Next()) {
        ShapeFix_Shell fix;
        fix.FixFaceOrientation(TopoDS::Shell(it.Current()));
        for (TopExp_Explorer fixed(fix.Shape(), TopAbs_SHELL); fixed.More(); fixed.Next()) {
            shells.push_back(fixed.Current());
        }
    }
    return shells;
}

TopoDS_Shape body_of_shell(const TopoDS_Shape& shell) {
    if (count_free_edges(shell) > 0) return shell;
    BRep_Builder builder;
    TopoDS_Solid solid;
    TopoDS_Shape closed = shell;
    closed.Closed(true);
    builder.MakeSolid(solid);
    builder.Add(solid, closed);
    BRepLib::OrientClosedSolid(solid);
    return solid;
}

}  // namespace

int count_free_edges(const TopoDS_Shape& shape) {
    TopTools_IndexedMapOfShape edges;
    std::vector<int> uses;
    for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) {
        for (TopExp_Explorer it(face.Current(), TopAbs_EDGE); it.More(); it.Next()) {
            if (BRep_Tool::Degenerated(TopoDS::Edge(it.Current()))) continue;
            const auto number = std::size_t(edges.Add(it.Current()));
            if (number > uses.size()) uses.push_back(0);
            ++uses[number - 1];
        }
    }
    int free = 0;
    for (const int n : uses)
        free += n == 1 ? 1 : 0;
    return free;
}

TopoDS_Shape keep_faces(const TopoDS_Shape& shape) {
    const Bodies bodies(shape);
    std::vector<TopoDS_Shape> kept = bodies.solids;
    kept.insert(kept.end(), bodies.shells.begin(), bodies.shells.end());
    kept.insert(kept.end(), bodies.faces.begin(), bodies.faces.end());
    return compound_of(kept);
}

TopoDS_Shape heal(const TopoDS_Shape& shape, double max_tolerance_rel, ReadReport& report) {
    const Bodies bodies(shape);
    std::vector<TopoDS_Shape> result;
    for (const TopoDS_Shape& solid : bodies.solids) {
        TopoDS_Solid oriented = TopoDS::Solid(solid);
        BRepLib::OrientClosedSolid(oriented);
        result.push_back(oriented);
    }
    std::vector<TopoDS_Shape> loose = bodies.shells;
    loose.insert(loose.end(), bodies.faces.begin(), bodies.faces.end());
    if (!loose.empty()) {
        TopoDS_Shape sheets = compound_of(loose);
        if (!bodies.faces.empty() || count_free_edges(sheets) > 0) {
            const Sewn sewn = sew_best(loose, diagonal_of(shape), max_tolerance_rel);
            if (!sewn.shape.IsNull()) {
                sheets = sewn.shape;
                report.sewing_tolerance_mm = sewn.tolerance;
                auto impl = std::make_shared<CadModel::Impl>();
                impl->shape = sheets;
                report.largest_gap_mm =
                    measure_continuity(CadModel(impl), geom::Points(0, 3)).max_gap_mm;
            } else {
                report.notices.push_back(
                    "sewing would swallow faces at any tolerance; the faces stay as they are");
            }
        }
        for (const TopoDS_Shape& shell : oriented_shells(sheets))
            result.push_back(body_of_shell(shell));
        for (TopExp_Explorer it(sheets, TopAbs_FACE, TopAbs_SHELL); it.More(); it.Next()) {
            result.push_back(it.Current());
        }
    }
    return compound_of(result);
}

}  // namespace patchwright::occ
