#include "occ/exchange/cad_model_impl.h"

#include <patchwright/base/error.h>

#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <fmt/format.h>

#include <numeric>

namespace patchwright::occ {

std::vector<std::vector<int>> connected_faces(const CadModel& model) {
    const std::vector<TopoDS_Face> faces = faces_of(model);
    std::vector<int> parent(faces.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int f) {
        while (parent[std::size_t(f)] != f)
            f = parent[std::size_t(f)] = parent[std::size_t(parent[std::size_t(f)])];
        return f;
    };
    TopTools_IndexedMapOfShape edges;
    std::vector<int> first;  // face of each edge
    for (std::size_t f = 0; f < faces.size(); ++f) {
        for (TopExp_Explorer it(faces[f], TopAbs_EDGE); it.More(); it.Next()) {
            if (BRep_Tool::Degenerated(TopoDS::Edge(it.Current()))) continue;
            const auto number = std::size_t(edges.Add(it.Current()));
            if (number > first.size()) first.push_back(int(f));
            const int a = root(first[number - 1]), b = root(int(f));
            parent[std::size_t(std::max(a, b))] = std::min(a, b);
        }
    }
    std::vector<std::vector<int>> parts;
    std::vector<int> part(faces.size(), -1);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        int& number = part[std::size_t(root(int(f)))];
        if (number < 0) {
            number = int(parts.size());
            parts.emplace_back();
        }
        parts[std::size_t(number)].push_back(int(f));
    }
    return parts;
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

}  // namespace patchwright::occ
