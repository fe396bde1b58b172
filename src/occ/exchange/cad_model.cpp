#include "occ/exchange/cad_model_impl.h"

#include <patchwright/base/error.h>

#include <BRep_Tool.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace patchwright::occ {

FileFormat file_format(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".step" || extension == ".stp") return FileFormat::Step;
    if (extension == ".iges" || extension == ".igs") return FileFormat::Iges;
    if (extension == ".brep" || extension == ".brp") return FileFormat::Brep;
    throw base::InputError(
        fmt::format("{}: unknown kind of CAD file; use .step, .stp, .iges, .igs, .brep or .brp",
                    path.string()));
}

std::vector<TopoDS_Face> faces_of(const CadModel& model) {
    TopTools_IndexedMapOfShape map;
    TopExp::MapShapes(model.impl().shape, TopAbs_FACE, map);
    std::vector<TopoDS_Face> faces;
    faces.reserve(static_cast<std::size_t>(map.Extent()));
    for (int i = 1; i <= map.Extent(); ++i) faces.push_back(TopoDS::Face(map(i)));
    return faces;
}

std::vector<std::string> face_names(const CadModel& model) {
    std::vector<std::string> names = model.impl().face_names;
    names.resize(faces_of(model).size());
    return names;
}

std::vector<std::optional<Colour>> face_colours(const CadModel& model) {
    std::vector<std::optional<Colour>> colours = model.impl().face_colours;
    colours.resize(faces_of(model).size());
    return colours;
}

CadModel with_face_names(const CadModel& model, std::vector<std::string> names) {
    const std::size_t faces = faces_of(model).size();
    if (names.size() != faces)
        throw base::InvalidArgument(
            fmt::format("{} names for {} faces; give one a face", names.size(), faces));
    auto impl = std::make_shared<CadModel::Impl>(model.impl());
    impl->face_names = std::move(names);
    return CadModel(std::move(impl));
}

CadModel with_face_colours(const CadModel& model, std::vector<std::optional<Colour>> colours) {
    const std::size_t faces = faces_of(model).size();
    if (colours.size() != faces)
        throw base::InvalidArgument(
            fmt::format("{} colours for {} faces; give one a face", colours.size(), faces));
    auto impl = std::make_shared<CadModel::Impl>(model.impl());
    impl->face_colours = std::move(colours);
    return CadModel(std::move(impl));
}

std::vector<int> edge_uses(const TopoDS_Shape& shape) {
    TopTools_IndexedMapOfShape edges;
    return edge_uses(shape, edges);
}

std::vector<int> edge_uses(const TopoDS_Shape& shape, TopTools_IndexedMapOfShape& edges) {
    std::vector<int> uses;
    for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) {
        for (TopExp_Explorer it(face.Current(), TopAbs_EDGE); it.More(); it.Next()) {
            if (BRep_Tool::Degenerated(TopoDS::Edge(it.Current()))) continue;
            const auto number = std::size_t(edges.Add(it.Current()));
            if (number > uses.size()) uses.push_back(0);
            ++uses[number - 1];
        }
    }
    return uses;
}

int count_free_edges(const TopoDS_Shape& shape) {
    const std::vector<int> uses = edge_uses(shape);
    return static_cast<int>(std::count(uses.begin(), uses.end(), 1));
}

}  // namespace patchwright::occ
