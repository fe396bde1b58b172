#include "geom/disjoint_sets.h"
#include "occ/exchange/cad_model_impl.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/cad_reference.h>

#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <fmt/format.h>

namespace patchwright::occ {

std::vector<std::vector<int>> connected_faces(const CadModel& model) {
    const std::vector<TopoDS_Face> faces = faces_of(model);
    geom::DisjointSets bodies(faces.size());
    TopTools_IndexedMapOfShape edges;
    std::vector<int> first;  // face of each edge
    for (std::size_t f = 0; f < faces.size(); ++f) {
        for (TopExp_Explorer it(faces[f], TopAbs_EDGE); it.More(); it.Next()) {
            if (BRep_Tool::Degenerated(TopoDS::Edge(it.Current()))) continue;
            const auto number = std::size_t(edges.Add(it.Current()));
            if (number > first.size()) first.push_back(int(f));
            bodies.join(first[number - 1], int(f));
        }
    }
    return bodies.sets();
}

CadModel part_of(const CadModel& model, const std::vector<int>& faces) {
    const std::vector<TopoDS_Face> all = faces_of(model);
    const auto names = face_names(model);
    const auto colours = face_colours(model);
    TopoDS_Compound compound;
    const BRep_Builder builder;
    builder.MakeCompound(compound);
    auto impl = std::make_shared<CadModel::Impl>();
    for (const int f : faces) {
        if (f < 0 || std::size_t(f) >= all.size())
            throw base::InvalidArgument(
                fmt::format("face {} of a model that has {}", f, all.size()));
        builder.Add(compound, all[std::size_t(f)]);
        impl->face_names.push_back(names[std::size_t(f)]);
        impl->face_colours.push_back(colours[std::size_t(f)]);
    }
    impl->shape = compound;
    return CadModel(std::move(impl));
}

std::vector<BodyReference> body_references(const CadModel& model, const ReferenceOptions& options) {
    std::vector<BodyReference> bodies;
    for (std::vector<int>& faces : connected_faces(model)) {
        try {
            auto surface = std::make_shared<const CadReference>(part_of(model, faces), options);
            bodies.push_back({std::move(faces), std::move(surface)});
        } catch (const base::InputError&) {
            continue;  // no triangles, and so no part of a cage
        }
    }
    return bodies;
}

}  // namespace patchwright::occ
