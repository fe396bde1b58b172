#include "occ/exchange/cad_model_impl.h"
#include "occ/foot/foot_point_engine.h"
#include "occ/heal/free_edge_gaps.h"
#include "occ/kernel_guard.h"
#include "occ/kernel_points.h"

#include <patchwright/base/error.h>
#include <patchwright/base/numbers.h>
#include <patchwright/occ/cad_reference.h>
#include <patchwright/occ/inspect_closely.h>

#include <BRepGProp.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <GProp_PrincipalProps.hxx>
#include <ShapeAnalysis_ShapeTolerance.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>

#include <algorithm>
#include <memory>

namespace patchwright::occ {

using base::infinity;
using geom::Vec3;

namespace {

double edge_length(const TopoDS_Shape& edge) {
    GProp_GProps properties;
    BRepGProp::LinearProperties(edge, properties);
    return properties.Mass();
}

void look_at_faces(const CadModel& model, CloseInspection& result) {
    result.smallest_area_mm2 = infinity;
    int number = 0;
    for (const TopoDS_Face& face : faces_of(model)) {
        GProp_GProps properties;
        BRepGProp::SurfaceProperties(face, properties);
        const double area = std::abs(properties.Mass());
        double perimeter = 0.0;
        for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
            if (!BRep_Tool::Degenerated(TopoDS::Edge(it.Current())))
                perimeter += edge_length(it.Current());
        }
        if (area < result.smallest_area_mm2) {
            result.smallest_area_mm2 = area;
            result.smallest_face = number;
        }
        const double width = 2.0 * area / perimeter;
        if (perimeter > 0.0 && (!result.narrowest || width < result.narrowest->width_mm))
            result.narrowest = {number, width};
        ++number;
    }
}

void look_at_edges(const TopoDS_Shape& shape, CloseInspection& result) {
    TopTools_IndexedMapOfShape edges;
    TopExp::MapShapes(shape, TopAbs_EDGE, edges);
    for (int i = 1; i <= edges.Extent(); ++i) {
        const TopoDS_Edge& edge = TopoDS::Edge(edges(i));
        if (BRep_Tool::Degenerated(edge)) continue;
        double first = 0.0, last = 0.0;
        const auto curve = BRep_Tool::Curve(edge, first, last);
        const double length = edge_length(edge);
        if (curve.IsNull() || (result.shortest_edge && length >= result.shortest_edge->length_mm))
            continue;
        result.shortest_edge = {length, vec(curve->Value(0.5 * (first + last)))};
    }
    const std::vector<double> gaps = free_edge_gaps(shape);
    if (gaps.empty() || gaps.front() == infinity) return;
    result.open_gaps = {gaps.front(), gaps.back()};
}

void look_at_tolerances(const TopoDS_Shape& shape, CloseInspection& result) {
    constexpr int largest = 1;
    ShapeAnalysis_ShapeTolerance tolerance;
    result.vertex_tolerance_mm = tolerance.Tolerance(shape, largest, TopAbs_VERTEX);
    result.edge_tolerance_mm = tolerance.Tolerance(shape, largest, TopAbs_EDGE);
    result.face_tolerance_mm = tolerance.Tolerance(shape, largest, TopAbs_FACE);
}

void look_at_features(const CadModel& model, const CloseInspectionOptions& options,
                      CloseInspection& result) {
    const CadReference reference(
        model, {.sharp_angle_rad = options.sharp_angle_rad, .progress = options.progress});
    const SearchModel& search = reference.search_model();
    for (const ModelEdge& edge : search.network.edges) {
        result.sharp_edges += edge.kind == EdgeKind::Sharp ? 1 : 0;
        if (edge.kind != EdgeKind::Smooth) continue;
        ++result.smooth_edges;
        if (edge.greatest_angle <= result.largest_kink_rad) continue;
        result.largest_kink_rad = edge.greatest_angle;
        result.largest_kink_at = edge.at(0.5 * (edge.first + edge.last));
    }
    for (const FaceSurface& surface : search.surfaces)
        result.kinked_faces += surface.has_kinks() ? 1 : 0;
    for (const geom::FeatureCurve& curve : reference.features().curves) {
        result.sharp_curves += curve.kind == geom::FeatureKind::Sharp ? 1 : 0;
        result.free_curves += curve.kind == geom::FeatureKind::Free ? 1 : 0;
    }
    result.corners = int(reference.features().corners.size());
}

void look_at_mass(const TopoDS_Shape& shape, CloseInspection& result) {
    GProp_GProps properties;
    const bool solid = TopExp_Explorer(shape, TopAbs_SOLID).More();
    if (solid)
        BRepGProp::VolumeProperties(shape, properties, false, true);
    else
        BRepGProp::SurfaceProperties(shape, properties);
    result.centre_of_mass = vec(properties.CentreOfMass());
    const GProp_PrincipalProps principal = properties.PrincipalProperties();
    principal.Moments(result.principal_moments[0], result.principal_moments[1],
                      result.principal_moments[2]);
    std::sort(result.principal_moments.begin(), result.principal_moments.end());
}

CadModel model_of(const TopoDS_Shape& shape) {
    auto impl = std::make_shared<CadModel::Impl>();
    impl->shape = shape;
    return CadModel(std::move(impl));
}

struct SampledSolid {
    CadReference reference;
    std::vector<geom::SurfaceSample> samples;
};

bool reaches_into(const SampledSolid& a, const SampledSolid& b, double depth) {
    const geom::Box3 box = b.reference.bounds();
    return std::any_of(a.samples.begin(), a.samples.end(), [&](const auto& sample) {
        if (box.squared_distance(sample.point) > 0.0) return false;
        const auto foot = b.reference.foot_point(sample.point);
        return foot.distance > depth && (sample.point - foot.point).dot(foot.normal) < 0.0;
    });
}

std::vector<std::array<int, 2>> find_overlaps(const CadModel& model,
                                              const base::Progress& progress) {
    constexpr double depth_rel = 1e-5, deflection_rel = 1e-3;
    constexpr int samples = 1000;
    std::vector<SampledSolid> bodies;
    for (TopExp_Explorer it(model.impl().shape, TopAbs_SOLID); it.More(); it.Next()) {
        CadReference reference(model_of(it.Current()),
                               {.deflection_rel = deflection_rel, .progress = progress});
        auto points = reference.sample(samples);
        bodies.push_back({std::move(reference), std::move(points)});
    }
    std::vector<std::array<int, 2>> result;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        base::report_progress(progress, "overlaps", double(i) / double(bodies.size()));
        for (std::size_t k = i + 1; k < bodies.size(); ++k) {
            const geom::Box3 a = bodies[i].reference.bounds(), b = bodies[k].reference.bounds();
            if ((a.max.array() < b.min.array()).any() || (b.max.array() < a.min.array()).any())
                continue;
            const double depth = depth_rel * std::min(a.diagonal(), b.diagonal());
            if (reaches_into(bodies[i], bodies[k], depth) ||
                reaches_into(bodies[k], bodies[i], depth))
                result.push_back({int(i), int(k)});
        }
    }
    return result;
}

}  // namespace

std::vector<std::array<int, 2>> overlapping_solids(const CadModel& model,
                                                   const base::Progress& progress) {
    int solids = 0;
    for (TopExp_Explorer it(model.impl().shape, TopAbs_SOLID); it.More(); it.Next()) ++solids;
    if (solids < 2) return {};
    return guard_kernel<base::InputError>("looking for overlapping solids",
                                          [&] { return find_overlaps(model, progress); });
}

CloseInspection inspect_closely(const CadModel& model, const CloseInspectionOptions& options) {
    return guard_kernel<base::InputError>("inspecting the model", [&] {
        CloseInspection result;
        const TopoDS_Shape& shape = model.impl().shape;
        look_at_faces(model, result);
        look_at_edges(shape, result);
        look_at_tolerances(shape, result);
        look_at_features(model, options, result);
        look_at_mass(shape, result);
        const auto names = face_names(model);
        const auto colours = face_colours(model);
        result.named_faces = int(std::count_if(names.begin(), names.end(),
                                               [](const auto& name) { return !name.empty(); }));
        result.coloured_faces = int(std::count_if(
            colours.begin(), colours.end(), [](const auto& colour) { return colour.has_value(); }));
        result.overlapping_solids = overlapping_solids(model, options.progress);
        return result;
    });
}

}  // namespace patchwright::occ
