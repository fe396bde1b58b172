#include "occ/exchange/lost_entities.h"

#include "occ/exchange/face_entities.h"
#include "occ/exchange/step_text.h"

#include <IGESControl_Reader.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Check.hxx>
#include <STEPControl_Reader.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_UndefinedEntity.hxx>
#include <StepGeom_Surface.hxx>
#include <StepShape_ConnectedFaceSet.hxx>
#include <StepShape_FaceSurface.hxx>
#include <StepShape_GeometricCurveSet.hxx>
#include <StepShape_ManifoldSolidBrep.hxx>
#include <StepShape_OrientedFace.hxx>
#include <StepShape_SolidModel.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Shape.hxx>
#include <TransferBRep.hxx>
#include <Transfer_Binder.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_set>
#include <utility>

namespace patchwright::occ {

namespace {

using Entity = Handle(Standard_Transient);
using Reason = std::optional<std::string>;

/// Which entities of a file have a face in the shape that came of it.
class Transferred {
  public:
    Transferred(const XSControl_Reader& reader, const TopoDS_Shape& shape)
        : process_(reader.WS()->TransferReader()->TransientProcess()) {
        each_face(shape, [&](const TopoDS_TShape* face) { faces_.insert(face); });
    }

    [[nodiscard]] bool gave_face(const Entity& entity) const {
        bool found = false;
        each_face(TransferBRep::ShapeResult(process_, entity),
                  [&](const TopoDS_TShape* face) { found = found || faces_.count(face) > 0; });
        return found;
    }

    /// What the kernel says about the transfer.
    [[nodiscard]] Reason failure(const Entity& entity) const {
        const Handle(Transfer_Binder) binder = process_->Find(entity);
        if (binder.IsNull() || !binder->Check()->HasFailed()) return std::nullopt;
        const std::string text = binder->Check()->CFail(1);
        return text.substr(std::min(text.find_first_not_of(' '), text.size()));
    }

  private:
    template <class Visit>
    static void each_face(const TopoDS_Shape& shape, Visit&& visit) {
        if (shape.IsNull()) return;
        for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
            visit(it.Current().TShape().get());
    }

    Handle(Transfer_TransientProcess) process_;
    std::unordered_set<const TopoDS_TShape*> faces_;
};

/// Collects the lost entities of a STEP file by their numbers.
class LostInStep {
  public:
    LostInStep(STEPControl_Reader& reader, const TopoDS_Shape& shape)
        : model_(reader.StepModel()), transferred_(reader, shape) {
        for (int i = 1; i <= model_->NbEntities(); ++i) look_at(model_->Entity(i));
    }

    std::vector<LostEntity> report(std::string_view text) {
        name_unknown_members(text);
        std::set<int> numbers;
        for (const auto& [number, reason] : lost_) numbers.insert(number);
        const auto instances = numbers.empty() ? StepInstances() : step_instances(text, numbers);
        std::vector<LostEntity> result;
        for (const auto& [number, reason] : lost_) {
            const auto found = instances.find(number);
            result.push_back(
                {fmt::format("#{}", number),
                 found == instances.end() ? "(not in the file)" : step_type(found->second),
                 reason});
        }
        return result;
    }

  private:
    void look_at(const Entity& entity) {
        if (const auto shell = Handle(StepShape_ConnectedFaceSet)::DownCast(entity)) {
            if (shell->CfsFaces().IsNull()) return;
            for (int i = 1; i <= shell->NbCfsFaces(); ++i)
                if (shell->CfsFacesValue(i).IsNull())
                    unknown_member(entity, shell->NbCfsFaces(), i);
        } else if (const auto set = Handle(StepShape_GeometricSet)::DownCast(entity)) {
            look_at_set(*set);
        } else if (entity->IsKind(STANDARD_TYPE(StepShape_Face))) {
            const bool other_way_round = entity->IsKind(STANDARD_TYPE(StepShape_OrientedFace));
            if (!other_way_round && !transferred_.gave_face(entity))
                lose(entity, face_reason(entity));
        } else if (entity->IsKind(STANDARD_TYPE(StepShape_SolidModel))) {
            // Boundary representations are counted by their faces.
            const bool by_faces = entity->IsKind(STANDARD_TYPE(StepShape_ManifoldSolidBrep));
            if (!by_faces && !transferred_.gave_face(entity))
                lose(entity, "solids of this type are not supported");
        }
    }

    void look_at_set(const StepShape_GeometricSet& set) {
        if (set.Elements().IsNull() || set.IsKind(STANDARD_TYPE(StepShape_GeometricCurveSet)))
            return;
        for (int i = 1; i <= set.NbElements(); ++i) {
            const Entity element = set.ElementsValue(i).Value();
            if (element.IsNull())
                unknown_member(&set, set.NbElements(), i);
            else if (element->IsKind(STANDARD_TYPE(StepGeom_Surface)) &&
                     !transferred_.gave_face(element))
                lose(element, transferred_.failure(element));
        }
    }

    [[nodiscard]] Reason face_reason(const Entity& entity) const {
        const auto face = Handle(StepShape_FaceSurface)::DownCast(entity);
        if (face.IsNull()) return "faces of this type are not supported";
        if (face->FaceGeometry().IsNull()) return "the type of its surface is not known";
        if (const Reason reason = transferred_.failure(face->FaceGeometry())) return reason;
        return transferred_.failure(entity);
    }

    void lose(const Entity& entity, Reason reason) {
        lost_.emplace(model_->IdentLabel(entity), std::move(reason));
    }

    /// The kernel drops references to what it does not know: only the text still has them.
    void unknown_member(const Entity& list, int members, int position) {
        unknown_[model_->IdentLabel(list)].push_back({members, position});
    }

    void lose_member(int number, int list) {
        for (int i = 1; i <= model_->NbEntities(); ++i) {
            if (model_->IdentLabel(model_->Entity(i)) != number) continue;
            lost_.emplace(number, model_->Entity(i)->IsKind(STANDARD_TYPE(StepData_UndefinedEntity))
                                      ? "unknown entity"
                                      : fmt::format("cannot be a member of #{}", list));
        }
        lost_.emplace(number, fmt::format("#{} refers to it", list));
    }

    void name_unknown_members(std::string_view text) {
        std::set<int> lists;
        for (const auto& [list, places] : unknown_) lists.insert(list);
        if (lists.empty()) return;
        for (const auto& [list, instance] : step_instances(text, lists)) {
            const std::vector<int> members = step_references(instance);
            for (const UnknownMember& unknown : unknown_[list]) {
                if (int(members.size()) == unknown.members)
                    lose_member(members[std::size_t(unknown.position) - 1], list);
                else
                    lost_.emplace(list, "a member is not known");
            }
        }
    }

    struct UnknownMember {
        int members;   ///< of the list
        int position;  ///< in the list, from 1
    };
    Handle(StepData_StepModel) model_;
    Transferred transferred_;
    std::map<int, std::vector<UnknownMember>> unknown_;
    std::map<int, Reason> lost_;
};

}  // namespace

std::vector<LostEntity> lost_in_step(STEPControl_Reader& reader, const TopoDS_Shape& shape,
                                     std::string_view text) {
    return LostInStep(reader, shape).report(text);
}

std::vector<LostEntity> lost_in_iges(IGESControl_Reader& reader, const TopoDS_Shape& shape) {
    const Handle(IGESData_IGESModel) model = reader.IGESModel();
    const Transferred transferred(reader, shape);
    std::vector<LostEntity> result;
    for (FaceEntity& face : iges_faces(model)) {
        if (transferred.gave_face(face.entity)) continue;
        const bool unreadable = model->Check(model->Number(face.entity), true)->HasFailed();
        result.push_back(
            {std::move(face.label), std::move(face.type),
             unreadable ? "its parameters are not readable" : transferred.failure(face.entity)});
    }
    return result;
}

}  // namespace patchwright::occ
