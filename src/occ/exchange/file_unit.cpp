#include "occ/exchange/file_unit.h"

#include "occ/exchange/iges_global.h"
#include "occ/exchange/step_text.h"

#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Check.hxx>
#include <STEPConstruct_UnitContext.hxx>
#include <StepBasic_NamedUnit.hxx>
#include <StepData_StepModel.hxx>
#include <StepGeom_GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx.hxx>
#include <StepGeom_GeometricRepresentationContextAndGlobalUnitAssignedContext.hxx>
#include <StepRepr_GlobalUnitAssignedContext.hxx>
#include <StepShape_ShapeRepresentation.hxx>
#include <TCollection_HAsciiString.hxx>
#include <fmt/format.h>

#include <cmath>

namespace patchwright::occ {

namespace {

using Context = Handle(StepRepr_RepresentationContext);

/// Null for contexts without units.
Handle(StepRepr_GlobalUnitAssignedContext) unit_context(const Context& context) {
    if (const auto own = Handle(StepRepr_GlobalUnitAssignedContext)::DownCast(context)) return own;
    using Plain = StepGeom_GeometricRepresentationContextAndGlobalUnitAssignedContext;
    if (const auto plain = Handle(Plain)::DownCast(context))
        return plain->GlobalUnitAssignedContext();
    using Uncertain = StepGeom_GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx;
    if (const auto uncertain = Handle(Uncertain)::DownCast(context))
        return uncertain->GlobalUnitAssignedContext();
    return nullptr;
}

/// The unit of length among those of a context; null where there is none.
Handle(StepBasic_NamedUnit)
    length_unit(const Handle(StepRepr_GlobalUnitAssignedContext) & units, double& millimetres) {
    if (units.IsNull() || units->Units().IsNull()) return nullptr;
    for (int i = 1; i <= units->NbUnits(); ++i) {
        STEPConstruct_UnitContext factors;
        if (units->UnitsValue(i).IsNull()) continue;
        factors.ComputeFactors(units->UnitsValue(i));
        if (!factors.LengthDone()) continue;
        millimetres = factors.LengthFactor();
        return units->UnitsValue(i);
    }
    return nullptr;
}

std::string describe(const Handle(StepData_StepModel) & model, std::string_view text,
                     const Handle(Standard_Transient) & entity) {
    const int number = model->IdentLabel(entity);
    const StepInstances found = step_instances(text, {number});
    return fmt::format("#{} {}", number, found.empty() ? "" : step_type(found.at(number)));
}

/// The numbers 1 to 11 have a meaning, 3 that of the unit's name.
/// Source: IGES 5.3, 2.2.4.3.14 and 15.
constexpr int by_name = 3, largest_flag = 11, millimetre_flag = 2;
constexpr std::size_t flag_parameter = 14, name_parameter = 15;

}  // namespace

FileUnit step_unit(const Handle(StepData_StepModel) & model, std::string_view text) {
    FileUnit result;
    bool first = true;
    for (int i = 1; i <= model->NbEntities(); ++i) {
        const auto shape = Handle(StepShape_ShapeRepresentation)::DownCast(model->Entity(i));
        if (shape.IsNull()) continue;
        // Without a unit the kernel takes lengths for millimetres.
        double millimetres = 1.0;
        const auto unit = length_unit(unit_context(shape->ContextOfItems()), millimetres);
        if (unit.IsNull()) {
            result.problem =
                fmt::format("{} has no known unit of length", describe(model, text, shape));
        } else if (const auto check = model->Check(model->Number(unit), true); check->HasFailed()) {
            result.problem = fmt::format("the unit of length {} is not known: {}",
                                         describe(model, text, unit), check->CFail(1));
        }
        if (first) result.millimetres = millimetres;
        if (millimetres != result.millimetres) result.differs = true;
        first = false;
    }
    if (first) result.problem = "has no shape with a unit of length";
    return result;
}

FileUnit iges_unit(const Handle(IGESData_IGESModel) & model, const std::string& text) {
    IGESData_GlobalSection global = model->GlobalSection();
    const int flag = global.UnitFlag();
    if (flag < 1 || flag > largest_flag) {
        global.SetUnitFlag(millimetre_flag);
        model->SetGlobalSection(global);
        return {.problem = fmt::format("the unit flag {} is not known", flag)};
    }
    FileUnit result{.millimetres = global.UnitValue()};
    // The kernel replaces the flag 3 by that of the name where it knows the name.
    if (flag == by_name)
        result.problem =
            fmt::format("the unit '{}' is not known",
                        global.UnitName().IsNull() ? "" : global.UnitName()->ToCString());
    const std::vector<std::string> parameters = iges_global_parameters(text);
    const auto is_given = [&](std::size_t n) {
        return n <= parameters.size() && !parameters[n - 1].empty();
    };
    if (!is_given(flag_parameter) && !is_given(name_parameter))
        result.problem = "names no unit of length";
    return result;
}

}  // namespace patchwright::occ
