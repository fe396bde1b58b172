#include "occ/exchange/face_attributes.h"

#include "occ/exchange/cad_model_impl.h"

#include <IGESBasic_Name.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGraph_Color.hxx>
#include <Quantity_Color.hxx>
#include <STEPConstruct.hxx>
#include <STEPConstruct_Styles.hxx>
#include <STEPControl_Reader.hxx>
#include <STEPControl_Writer.hxx>
#include <StepData_StepModel.hxx>
#include <StepGeom_Surface.hxx>
#include <StepShape_FaceSurface.hxx>
#include <StepVisual_Colour.hxx>
#include <StepVisual_MechanicalDesignGeometricPresentationRepresentation.hxx>
#include <StepVisual_PresentationStyleAssignment.hxx>
#include <StepVisual_StyledItem.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TransferBRep.hxx>
#include <TransferBRep_ShapeMapper.hxx>
#include <Transfer_FinderProcess.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_TransferWriter.hxx>
#include <XSControl_WorkSession.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace patchwright::occ {

namespace {

FaceAttributes& attributes_of(const TopoDS_Shape& face, FaceAttributeMap& map) {
    FaceAttributes& result = map[face.TShape().get()];
    result.face = face.TShape();
    return result;
}

template <class Visit>
void each_face(const TopoDS_Shape& shape, FaceAttributeMap& map, Visit&& visit) {
    if (shape.IsNull()) return;
    for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
        visit(attributes_of(it.Current(), map));
}

std::string trimmed(const Handle(TCollection_HAsciiString) & text) {
    std::string result = text.IsNull() ? "" : text->ToCString();
    result.erase(0, std::min(result.find_first_not_of(' '), result.size()));
    result.erase(result.find_last_not_of(' ') + 1);
    return result;
}

Colour colour_of(const Quantity_Color& colour) {
    Colour result;
    colour.Values(result.red, result.green, result.blue, Quantity_TOC_sRGB);
    return result;
}

Quantity_Color kernel_colour(const Colour& c) {
    return {c.red, c.green, c.blue, Quantity_TOC_sRGB};
}

void read_step_names(const Handle(XSControl_WorkSession) & session, FaceAttributeMap& result) {
    const auto process = session->TransferReader()->TransientProcess();
    const auto model = Handle(StepData_StepModel)::DownCast(session->Model());
    for (int i = 1; i <= model->NbEntities(); ++i) {
        const Handle(Standard_Transient) entity = model->Entity(i);
        // Surfaces of a geometric set become faces of their own.
        const bool of_interest = entity->IsKind(STANDARD_TYPE(StepShape_FaceSurface)) ||
                                 entity->IsKind(STANDARD_TYPE(StepGeom_Surface));
        if (!of_interest) continue;
        const auto item = Handle(StepRepr_RepresentationItem)::DownCast(entity);
        const std::string name = trimmed(item->Name());
        if (name.empty() || name == "NONE") continue;
        const TopoDS_Shape shape = STEPConstruct::FindShape(process, item);
        if (shape.IsNull() || shape.ShapeType() != TopAbs_FACE) continue;
        attributes_of(shape, result).name = name;
    }
}

/// Colour of the surface, else of what is rendered, else of the boundary.
std::optional<Colour> style_colour(const STEPConstruct_Styles& styles,
                                   const Handle(StepVisual_StyledItem) & style) {
    Handle(StepVisual_Colour) surface, boundary, curve, rendered;
    double transparency = 0.0;
    bool component = false;
    if (!styles.GetColors(style, surface, boundary, curve, rendered, transparency, component))
        return std::nullopt;
    for (const auto& colour : {surface, rendered}) {
        Quantity_Color found;
        if (!colour.IsNull() && STEPConstruct_Styles::DecodeColor(colour, found))
            return colour_of(found);
    }
    return std::nullopt;
}

void read_step_colours(const Handle(XSControl_WorkSession) & session, FaceAttributeMap& result) {
    const auto process = session->TransferReader()->TransientProcess();
    STEPConstruct_Styles styles(session);
    if (!styles.LoadStyles()) return;
    // From whole parts to single faces, so that the nearest style wins.
    std::multimap<TopAbs_ShapeEnum, std::pair<TopoDS_Shape, Colour>> found;
    for (int i = 1; i <= styles.NbStyles(); ++i) {
        const Handle(StepVisual_StyledItem) style = styles.Style(i);
        const auto colour = style.IsNull() ? std::nullopt : style_colour(styles, style);
        if (!colour || style->Item().IsNull()) continue;
        const TopoDS_Shape shape = STEPConstruct::FindShape(process, style->Item());
        if (shape.IsNull()) continue;
        found.emplace(shape.ShapeType(), std::pair(shape, *colour));
    }
    for (const auto& [type, styled] : found) {
        const auto& colour = styled.second;
        each_face(styled.first, result, [&](FaceAttributes& face) { face.colour = colour; });
    }
}

/// Longer names go into a property of their own.
constexpr std::size_t iges_label_length = 8;

std::optional<Colour> iges_colour(const IGESData_IGESEntity& entity) {
    // 1 to 8: black, red, green, blue, yellow, magenta, cyan, white; 0: none.
    constexpr std::array<Colour, 8> standard{
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}};
    if (entity.DefColor() == IGESData_DefReference) {
        const auto colour = Handle(IGESGraph_Color)::DownCast(entity.Color());
        if (colour.IsNull()) return std::nullopt;
        Colour percent;
        colour->RGBIntensity(percent.red, percent.green, percent.blue);
        return Colour{percent.red / 100.0, percent.green / 100.0, percent.blue / 100.0};
    }
    const int rank = entity.RankColor();
    if (rank < 1 || rank > int(standard.size())) return std::nullopt;
    return standard[std::size_t(rank) - 1];
}

std::string iges_name(const IGESData_IGESEntity& entity) {
    if (entity.HasName()) return trimmed(entity.NameValue());
    if (!entity.HasShortLabel()) return {};
    std::string name = trimmed(entity.ShortLabel());
    if (!name.empty() && entity.HasSubScriptNumber())
        name += fmt::format("({})", entity.SubScriptNumber());
    return name;
}

}  // namespace

FaceAttributeMap step_attributes(STEPControl_Reader& reader) {
    FaceAttributeMap result;
    read_step_names(reader.WS(), result);
    read_step_colours(reader.WS(), result);
    return result;
}

FaceAttributeMap iges_attributes(IGESControl_Reader& reader) {
    FaceAttributeMap result;
    const Handle(IGESData_IGESModel) model = reader.IGESModel();
    const auto process = reader.WS()->TransferReader()->TransientProcess();
    // From groups and bodies to single faces.
    std::multimap<TopAbs_ShapeEnum, std::pair<TopoDS_Shape, FaceAttributes>> found;
    for (int i = 1; i <= model->NbEntities(); ++i) {
        const Handle(IGESData_IGESEntity) entity = model->Entity(i);
        FaceAttributes attributes{iges_name(*entity), iges_colour(*entity), nullptr};
        if (attributes.name.empty() && !attributes.colour) continue;
        const TopoDS_Shape shape = TransferBRep::ShapeResult(process, entity);
        if (!shape.IsNull()) found.emplace(shape.ShapeType(), std::pair(shape, attributes));
    }
    for (const auto& [type, given] : found) {
        const FaceAttributes& attributes = given.second;
        const bool single = type == TopAbs_FACE;
        each_face(given.first, result, [&](FaceAttributes& face) {
            if (attributes.colour) face.colour = attributes.colour;
            if (single && !attributes.name.empty()) face.name = attributes.name;
        });
    }
    return result;
}

void write_step_attributes(STEPControl_Writer& writer, const CadModel& model) {
    const auto process = writer.WS()->TransferWriter()->FinderProcess();
    const auto faces = faces_of(model);
    const auto& names = model.impl().face_names;
    const auto& colours = model.impl().face_colours;
    STEPConstruct_Styles styles(writer.WS());
    // Faces of equal colours share one style.
    std::map<std::array<double, 3>, Handle(StepVisual_PresentationStyleAssignment)> known;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto item = STEPConstruct::FindEntity(process, faces[f]);
        if (item.IsNull()) continue;
        if (f < names.size()) item->SetName(new TCollection_HAsciiString(names[f].c_str()));
        if (f >= colours.size() || !colours[f]) continue;
        const Colour& c = *colours[f];
        auto& style = known[{c.red, c.green, c.blue}];
        if (style.IsNull()) {
            const auto colour = STEPConstruct_Styles::EncodeColor(kernel_colour(c));
            style = styles.MakeColorPSA(item, colour, colour, colour, 0.0);
        }
        styles.AddStyle(item, style, nullptr);
    }
    if (styles.NbStyles() == 0) return;
    Handle(StepVisual_MechanicalDesignGeometricPresentationRepresentation) all;
    if (styles.CreateMDGPR(styles.FindContext(model.impl().shape), all))
        Handle(StepData_StepModel)::DownCast(writer.WS()->Model())->AddWithRefs(all);
}

void write_iges_attributes(IGESControl_Writer& writer, const CadModel& model) {
    const auto process = writer.TransferProcess();
    const auto faces = faces_of(model);
    const auto& names = model.impl().face_names;
    const auto& colours = model.impl().face_colours;
    std::map<std::array<double, 3>, Handle(IGESGraph_Color)> known;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        Handle(Standard_Transient) found;
        const Handle(TransferBRep_ShapeMapper) mapper =
            TransferBRep::ShapeMapper(process, faces[f]);
        if (!process->FindTypedTransient(mapper, STANDARD_TYPE(IGESData_IGESEntity), found))
            continue;
        const auto entity = Handle(IGESData_IGESEntity)::DownCast(found);
        if (f < names.size() && !names[f].empty()) {
            entity->SetLabel(
                new TCollection_HAsciiString(names[f].substr(0, iges_label_length).c_str()));
            if (names[f].size() > iges_label_length) {
                const Handle(IGESBasic_Name) property = new IGESBasic_Name();
                property->Init(1, new TCollection_HAsciiString(names[f].c_str()));
                writer.AddEntity(property);
                entity->AddProperty(property);
            }
        }
        if (f >= colours.size() || !colours[f]) continue;
        const Colour& c = *colours[f];
        auto& colour = known[{c.red, c.green, c.blue}];
        if (colour.IsNull()) {
            colour = new IGESGraph_Color();
            colour->Init(100.0 * c.red, 100.0 * c.green, 100.0 * c.blue, nullptr);
            writer.AddEntity(colour);
        }
        entity->InitColor(colour);
    }
}

}  // namespace patchwright::occ
