#include "occ/exchange/face_entities.h"

#include "occ/exchange/step_text.h"

#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_EntityIterator.hxx>
#include <Interface_Graph.hxx>
#include <StepData_StepModel.hxx>
#include <StepShape_Face.hxx>
#include <StepShape_OrientedFace.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

namespace patchwright::occ {

namespace {

struct IgesType {
    int number;
    const char* name;
    bool part_of_others;  ///< also serves as geometry of other surfaces and faces
};

/// Planes of form 0 and the surfaces 190 to 198 have no bounds of their own.
constexpr std::array<IgesType, 20> iges_types{{
    {108, "bounded plane", true},
    {114, "parametric spline surface", true},
    {118, "ruled surface", true},
    {120, "surface of revolution", true},
    {122, "tabulated cylinder", true},
    {128, "B-spline surface", true},
    {140, "offset surface", true},
    {143, "bounded surface", false},
    {144, "trimmed surface", false},
    {150, "block", true},
    {152, "wedge", true},
    {154, "cylinder", true},
    {156, "cone", true},
    {158, "sphere", true},
    {160, "torus", true},
    {162, "solid of revolution", true},
    {164, "solid of linear extrusion", true},
    {168, "ellipsoid", true},
    {180, "boolean tree", true},
    {510, "face", false},
}};

const IgesType* iges_type(const IGESData_IGESEntity& entity) {
    const auto found =
        std::find_if(iges_types.begin(), iges_types.end(),
                     [&](const IgesType& type) { return type.number == entity.TypeNumber(); });
    if (found == iges_types.end() || (found->number == 108 && entity.FormNumber() == 0))
        return nullptr;
    // Entity use flag: 1 annotation, 5 curves in parameters, 6 construction
    // (IGES 5.3, 2.2.4.4.9.3).
    const int use = entity.UseFlag();
    return use == 1 || use == 5 || use == 6 ? nullptr : &*found;
}

/// Whether geometry or topology refers to an entity, other than groups, views and properties do.
bool serves_others(const Interface_Graph& graph, const Handle(Standard_Transient) & entity) {
    const auto is_geometry = [](int type) { return type < 200 || (type >= 502 && type <= 514); };
    for (Interface_EntityIterator it = graph.Sharings(entity); it.More(); it.Next()) {
        const auto by = Handle(IGESData_IGESEntity)::DownCast(it.Value());
        if (!by.IsNull() && is_geometry(by->TypeNumber())) return true;
    }
    return false;
}

}  // namespace

std::vector<FaceEntity> step_faces(const Handle(StepData_StepModel) & model,
                                   std::string_view text) {
    std::vector<FaceEntity> result;
    std::set<int> numbers;
    for (int i = 1; i <= model->NbEntities(); ++i) {
        const Handle(Standard_Transient) entity = model->Entity(i);
        if (!entity->IsKind(STANDARD_TYPE(StepShape_Face)) ||
            entity->IsKind(STANDARD_TYPE(StepShape_OrientedFace)))
            continue;
        numbers.insert(model->IdentLabel(entity));
        result.push_back({entity, "", ""});
    }
    const StepInstances instances = step_instances(text, numbers);
    for (FaceEntity& face : result) {
        const int number = model->IdentLabel(face.entity);
        const auto found = instances.find(number);
        face.label = fmt::format("#{}", number);
        if (found != instances.end()) face.type = step_type(found->second);
    }
    return result;
}

std::vector<FaceEntity> iges_faces(const Handle(IGESData_IGESModel) & model) {
    const Interface_Graph graph(model);
    std::vector<FaceEntity> result;
    for (int i = 1; i <= model->NbEntities(); ++i) {
        const Handle(IGESData_IGESEntity) entity = model->Entity(i);
        const IgesType* type = iges_type(*entity);
        if (type == nullptr || (type->part_of_others && serves_others(graph, entity))) continue;
        result.push_back({Handle(Standard_Transient)(entity),
                          fmt::format("D{}", model->DNum(entity)),
                          fmt::format("{} {}", type->number, type->name)});
    }
    return result;
}

}  // namespace patchwright::occ
