#include "occ/heal/sewing.h"

#include "occ/exchange/cad_model_impl.h"
#include "occ/heal/free_edge_gaps.h"
#include "occ/kernel_progress.h"

#include <BRepBuilderAPI_Sewing.hxx>
#include <BRep_Builder.hxx>
#include <TopExp.hxx>
#include <TopoDS_Compound.hxx>

#include <algorithm>

namespace patchwright::occ {

namespace {

// Of the size: gaps below are rounding.
constexpr double rounding_rel = 1e-8;
// A gap this much larger than the next smaller one has another cause.
constexpr double cluster_ratio = 3.0;
// The gaps are sampled, and the kernel looks elsewhere.
constexpr double margin = 1.5, wide_margin = 4.0;

using FaceMap = TopTools_IndexedMapOfShape;

FaceMap faces_in(const TopoDS_Shape& shape) {
    FaceMap map;
    TopExp::MapShapes(shape, TopAbs_FACE, map);
    return map;
}

std::vector<double> tolerances(const std::vector<double>& gaps, double size, double limit) {
    std::vector<double> result;
    double largest = 0.0;
    const auto add = [&](double wanted) {
        const double tolerance = std::min(wanted, limit);
        if (result.empty() || tolerance > result.back()) result.push_back(tolerance);
    };
    for (const double gap : gaps) {
        if (gap > limit) break;
        const double at_least = std::max(gap, rounding_rel * size);
        if (largest > 0.0 && at_least > cluster_ratio * largest) add(margin * largest);
        largest = at_least;
    }
    if (largest > 0.0) {
        add(margin * largest);
        add(wide_margin * largest);
    }
    return result;
}

class SewingPass {
  public:
    SewingPass(const std::vector<TopoDS_Shape>& parts, double tolerance,
               const base::Progress& progress)
        : sewing_(tolerance) {
        // Shorter edges are points: taken for curves, those of a pole are compared pair by pair.
        sewing_.SetMinTolerance(tolerance);
        for (const TopoDS_Shape& part : parts) sewing_.Add(part);
        const Handle(KernelProgress) polled = new KernelProgress(progress, "read", 0.6);
        sewing_.Perform(polled->Start());
        polled->check();
        sewn_ = {sewing_.SewedShape(), tolerance, 0};
    }
    /// No face was removed and none joined to more than one other along an edge.
    [[nodiscard]] bool sound(int faces) {
        if (sewn_.shape.IsNull() || sewing_.NbMultipleEdges() > 0) return false;
        if (faces_in(sewn_.shape).Extent() != faces) return false;
        sewn_.free_edges = count_free_edges(sewn_.shape);
        return true;
    }
    [[nodiscard]] const Sewn& sewn() const { return sewn_; }
    void note(const FaceMap& before, FaceOrigins& origins) const {
        for (int i = 1; i <= before.Extent(); ++i)
            origins.replaced(before(i), sewing_.ModifiedSubShape(before(i)));
    }

  private:
    BRepBuilderAPI_Sewing sewing_;
    Sewn sewn_;
};

}  // namespace

Sewn sew_by_gaps(const std::vector<TopoDS_Shape>& parts, const SewingOptions& options,
                 FaceOrigins& origins) {
    const BRep_Builder builder;
    TopoDS_Compound all;
    builder.MakeCompound(all);
    for (const TopoDS_Shape& part : parts) builder.Add(all, part);
    const FaceMap faces = faces_in(all);
    const std::vector<double> gaps = free_edge_gaps(all);

    Sewn best;
    const auto attempt = [&](double tolerance, bool wholly) {
        base::report_progress(options.progress, "read", 0.6);
        SewingPass tried(parts, tolerance, options.progress);
        if (!tried.sound(faces.Extent())) return;
        if (wholly && tried.sewn().free_edges > 0) return;
        // Edges that became points were not joined.
        if (!best.shape.IsNull() && count_free_edges_beyond(tried.sewn().shape, tolerance) >=
                                        count_free_edges_beyond(best.shape, tolerance))
            return;
        best = tried.sewn();
        tried.note(faces, origins);
    };
    const auto done = [&] { return !best.shape.IsNull() && best.free_edges == 0; };
    const double partly = std::min(options.max_partly_rel, options.max_wholly_rel) * options.size;
    for (const double tolerance : tolerances(gaps, options.size, partly)) {
        if (!done()) attempt(tolerance, false);
    }
    const double wholly = options.max_wholly_rel * options.size;
    for (const double tolerance : tolerances(gaps, options.size, wholly)) {
        if (!done() && tolerance > partly) attempt(tolerance, true);
    }
    return best;
}

}  // namespace patchwright::occ
