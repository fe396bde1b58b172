#include "occ/brep/bodies.h"

#include <BRepClass3d_SolidClassifier.hxx>
#include <BRep_Builder.hxx>
#include <Precision.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Solid.hxx>

#include <algorithm>

namespace patchwright::occ {

namespace {

/// Face by face: of a solid's outer shell the kernel's STEP and IGES writers forget that it is
/// reversed as a whole.
TopoDS_Shell turned(const TopoDS_Shell& shell) {
    const BRep_Builder builder;
    TopoDS_Shell result;
    builder.MakeShell(result);
    for (TopExp_Explorer it(shell, TopAbs_FACE); it.More(); it.Next())
        builder.Add(result, it.Current().Reversed());
    result.Closed(shell.Closed());
    return result;
}

TopoDS_Solid solid_of(const ShellPart& part) {
    const BRep_Builder builder;
    TopoDS_Solid solid;
    builder.MakeSolid(solid);
    builder.Add(solid, part.volume < 0.0 ? turned(part.shell) : part.shell);
    return solid;
}

bool holds(const ShellPart& outer, const TopoDS_Solid& outer_solid, const ShellPart& inner) {
    if ((inner.box.min.array() < outer.box.min.array()).any() ||
        (inner.box.max.array() > outer.box.max.array()).any()) {
        return false;
    }
    // Part of another that crosses it is inside as well, so all points are asked.
    BRepClass3d_SolidClassifier classifier(outer_solid);
    return std::all_of(inner.points.begin(), inner.points.end(), [&](const geom::Vec3& p) {
        classifier.Perform(gp_Pnt(p.x(), p.y(), p.z()), Precision::Confusion());
        return classifier.State() == TopAbs_IN;
    });
}

}  // namespace

std::vector<TopoDS_Shape> make_bodies(const std::vector<ShellPart>& parts) {
    std::vector<TopoDS_Solid> solids(parts.size());
    for (std::size_t k = 0; k < parts.size(); ++k) {
        if (parts[k].closed) solids[k] = solid_of(parts[k]);
    }
    std::vector<std::vector<std::size_t>> around(parts.size());
    for (std::size_t k = 0; k < parts.size(); ++k) {
        for (std::size_t l = 0; l < parts.size(); ++l) {
            const bool both = k != l && parts[k].closed && parts[l].closed;
            if (both && holds(parts[l], solids[l], parts[k])) around[k].push_back(l);
        }
    }
    const BRep_Builder builder;
    std::vector<char> is_void(parts.size(), 0);
    for (std::size_t k = 0; k < parts.size(); ++k) {
        if (around[k].size() % 2 == 0) continue;
        is_void[k] = 1;
        // The innermost of those around it is the one that most are around.
        const std::size_t owner = *std::max_element(
            around[k].begin(), around[k].end(),
            [&](std::size_t a, std::size_t b) { return around[a].size() < around[b].size(); });
        builder.Add(solids[owner], parts[k].volume > 0.0 ? parts[k].shell.Reversed()
                                                         : TopoDS_Shape(parts[k].shell));
    }
    std::vector<TopoDS_Shape> bodies;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        if (is_void[k] != 0) continue;
        bodies.push_back(parts[k].closed ? TopoDS_Shape(solids[k]) : TopoDS_Shape(parts[k].shell));
    }
    return bodies;
}

}  // namespace patchwright::occ
