#include "occ/heal/heal.h"

#include "occ/exchange/cad_model_impl.h"
#include "occ/heal/edge_pairing.h"
#include "occ/heal/face_cleanup.h"
#include "occ/heal/free_edge_gaps.h"
#include "occ/heal/pcurve_repair.h"
#include "occ/heal/sewing.h"

#include <patchwright/occ/inspect.h>

#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
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

#include <map>
#include <vector>

namespace patchwright::occ {

namespace {

/// Of the model's size: how far a p-curve may be from its edge in any case. A quarter of the
/// default tolerance: what is nearer decides nothing.
constexpr double off_edge_rel = 2.5e-5;

TopoDS_Shape compound_of(const std::vector<TopoDS_Shape>& shapes) {
    if (shapes.size() == 1) return shapes.front();
    BRep_Builder builder;
    TopoDS_Compound compound;
    builder.MakeCompound(compound);
    for (const TopoDS_Shape& shape : shapes) builder.Add(compound, shape);
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

/// Which faces share which edges, and how they run them.
class FaceGraph {
  public:
    explicit FaceGraph(const TopoDS_Shape& shape) {
        TopTools_IndexedMapOfShape faces;
        TopExp::MapShapes(shape, TopAbs_FACE, faces);
        for (int f = 1; f <= faces.Extent(); ++f) {
            faces_.push_back(faces(f));
            for (TopExp_Explorer it(faces(f), TopAbs_EDGE); it.More(); it.Next()) {
                if (BRep_Tool::Degenerated(TopoDS::Edge(it.Current()))) continue;
                const auto edge = std::size_t(edges_.Add(it.Current()));
                if (edge > uses_.size()) uses_.emplace_back();
                uses_[edge - 1].push_back({f - 1, it.Current().Orientation() == TopAbs_FORWARD});
            }
        }
        neighbours_.resize(faces_.size());
        for (const auto& uses : uses_) {
            if (uses.size() != 2 || uses[0].face == uses[1].face) continue;
            const bool agree = uses[0].forward != uses[1].forward;
            neighbours_[std::size_t(uses[0].face)].push_back({uses[1].face, agree});
            neighbours_[std::size_t(uses[1].face)].push_back({uses[0].face, agree});
        }
    }

    /// One shell for each part that hangs together; the faces that disagree with the part's
    /// majority are turned. Where a one-sided part cannot agree, its faces keep what they were
    /// given first.
    [[nodiscard]] std::vector<TopoDS_Shape> shells() const {
        std::vector<TopoDS_Shape> shells;
        std::vector<signed char> turned(faces_.size(), -1);
        for (std::size_t seed = 0; seed < faces_.size(); ++seed) {
            if (turned[seed] >= 0) continue;
            std::vector<int> part{static_cast<int>(seed)};
            turned[seed] = 0;
            std::size_t turned_count = 0;
            for (std::size_t next = 0; next < part.size(); ++next) {
                const auto f = std::size_t(part[next]);
                turned_count += turned[f] != 0 ? 1 : 0;
                for (const AdjacentFace& n : neighbours_[f]) {
                    auto& state = turned[std::size_t(n.face)];
                    if (state >= 0) continue;
                    state = static_cast<signed char>(n.agrees ? turned[f] : 1 - turned[f]);
                    part.push_back(n.face);
                }
            }
            const bool invert = 2 * turned_count > part.size();
            BRep_Builder builder;
            TopoDS_Shell shell;
            builder.MakeShell(shell);
            for (const int f : part) {
                const TopoDS_Shape& face = faces_[std::size_t(f)];
                builder.Add(shell,
                            (turned[std::size_t(f)] != 0) != invert ? face.Reversed() : face);
            }
            shells.push_back(shell);
        }
        return shells;
    }

  private:
    struct Use {
        int face;
        bool forward;
    };
    struct AdjacentFace {
        int face;
        bool agrees;
    };
    std::vector<TopoDS_Shape> faces_;
    TopTools_IndexedMapOfShape edges_;
    std::vector<std::vector<Use>> uses_;
    std::vector<std::vector<AdjacentFace>> neighbours_;
};

std::string gap_text(double gap, double size) {
    return fmt::format("{:.3g} mm, {:.2g} of the diagonal", gap, gap / size);
}

void note_open_edges(const TopoDS_Shape& shape, double size, ReadReport& report) {
    const std::vector<double> gaps = free_edge_gaps(shape);
    if (gaps.empty()) return;
    report.open_gaps = {gaps.front(), gaps.back()};
    report.notices.push_back(
        fmt::format("{} free edges stay open; the next edge is between {} and {} away", gaps.size(),
                    gap_text(gaps.front(), size), gap_text(gaps.back(), size)));
}

/// Sheets that sewing does not improve stay as they are.
TopoDS_Shape sew_sheets(const std::vector<TopoDS_Shape>& sheets, double size,
                        double max_tolerance_rel, ReadReport& report, FaceOrigins& origins,
                        const base::Progress& progress) {
    const TopoDS_Shape as_is = compound_of(sheets);
    const int free_edges = count_free_edges(as_is);
    if (free_edges == 0) return as_is;
    const SewingOptions options{
        .size = size, .max_wholly_rel = max_tolerance_rel, .progress = progress};
    Sewn sewn = sew_by_gaps(sheets, options, origins);
    // Without a gap within the limit there was nothing to try.
    if (sewn.shape.IsNull() || sewn.free_edges >= free_edges) {
        note_open_edges(as_is, size, report);
        return as_is;
    }
    report.pcurves_replaced = bring_pcurves_into_step(sewn.shape, sewn.tolerance);
    report.edges_rejoined = pair_coincident_edges(sewn.shape, sewn.tolerance, origins);
    if (report.edges_rejoined > 0)
        report.pcurves_replaced += bring_pcurves_into_step(sewn.shape, sewn.tolerance);
    auto impl = std::make_shared<CadModel::Impl>();
    impl->shape = sewn.shape;
    const double closed = measure_continuity(CadModel(impl), geom::Points(0, 3)).max_gap_mm;
    report.sewn = {.largest_mm = closed, .tolerance_mm = sewn.tolerance};
    if (sewn.tolerance > options.max_partly_rel * size) {
        report.notices.push_back(fmt::format(
            "sewing closed gaps of up to {}; look whether that is meant", gap_text(closed, size)));
    }
    note_open_edges(sewn.shape, size, report);
    return sewn.shape;
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

/// Faces that look the other way than they did; instances of one face count where all agree.
int count_turned(const TopoDS_Shape& before, const TopoDS_Shape& after,
                 const FaceOrigins& origins) {
    std::map<const TopoDS_TShape*, TopAbs_Orientation> was;
    for (TopExp_Explorer it(before, TopAbs_FACE); it.More(); it.Next())
        was.emplace(it.Current().TShape().get(), it.Current().Orientation());
    int turned = 0;
    for (TopExp_Explorer it(after, TopAbs_FACE); it.More(); it.Next()) {
        const auto found = was.find(origins.origin(it.Current()));
        turned += found != was.end() && found->second != it.Current().Orientation() ? 1 : 0;
    }
    return turned;
}

}  // namespace

TopoDS_Shape keep_faces(const TopoDS_Shape& shape) {
    const Bodies bodies(shape);
    std::vector<TopoDS_Shape> kept = bodies.solids;
    kept.insert(kept.end(), bodies.shells.begin(), bodies.shells.end());
    kept.insert(kept.end(), bodies.faces.begin(), bodies.faces.end());
    return compound_of(kept);
}

TopoDS_Shape heal(const TopoDS_Shape& shape, double size_mm, double max_tolerance_rel,
                  ReadReport& report, FaceOrigins& origins, const base::Progress& progress) {
    report.pcurves_projected = bring_pcurves_onto_edges(shape, off_edge_rel * size_mm);
    if (report.pcurves_projected > 0)
        report.notices.push_back(
            fmt::format("{} trimming curves left their edges, which are followed instead",
                        report.pcurves_projected));
    const Bodies bodies(shape);
    std::vector<TopoDS_Shape> solids;
    std::vector<TopoDS_Shape> loose = bodies.shells;
    loose.insert(loose.end(), bodies.faces.begin(), bodies.faces.end());
    for (const TopoDS_Shape& solid : bodies.solids) {
        // Some are closed by name only.
        (count_free_edges(solid) > 0 ? loose : solids).push_back(solid);
    }
    std::vector<TopoDS_Shape> result;
    for (const TopoDS_Shape& solid : solids) {
        TopoDS_Solid oriented = TopoDS::Solid(solid);
        BRepLib::OrientClosedSolid(oriented);
        result.push_back(oriented);
    }
    if (!loose.empty()) {
        const CleanedParts cleaned = drop_duplicates_and_slivers(loose, solids, size_mm);
        report.duplicates_dropped = cleaned.duplicates;
        report.slivers_dropped = cleaned.slivers;
        if (cleaned.duplicates + cleaned.slivers > 0) {
            report.notices.push_back(
                fmt::format("{} faces that lie on others and {} without width are left out",
                            cleaned.duplicates, cleaned.slivers));
        }
        if (!cleaned.parts.empty()) {
            const TopoDS_Shape sheets =
                sew_sheets(cleaned.parts, size_mm, max_tolerance_rel, report, origins, progress);
            for (const TopoDS_Shape& shell : FaceGraph(sheets).shells())
                result.push_back(body_of_shell(shell));
        }
    }
    const TopoDS_Shape healed = compound_of(result);
    report.faces_turned = count_turned(shape, healed, origins);
    if (report.faces_turned > 0) {
        report.notices.push_back(
            fmt::format("{} faces turned to agree with their neighbours and to look outward",
                        report.faces_turned));
    }
    return healed;
}

}  // namespace patchwright::occ
