#include "occ/exchange/cad_model_impl.h"
#include "occ/exchange/exchange_session.h"
#include "occ/exchange/face_attributes.h"
#include "occ/exchange/step_annotations.h"
#include "occ/exchange/step_text.h"
#include "occ/kernel_guard.h"

#include <patchwright/base/error.h>
#include <patchwright/base/output_set.h>
#include <patchwright/base/version.h>

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Geom_BSplineSurface.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_FloatWriter.hxx>
#include <STEPConstruct_ContextTool.hxx>
#include <STEPControl_ActorWrite.hxx>
#include <STEPControl_Writer.hxx>
#include <StepBasic_CalendarDate.hxx>
#include <StepBasic_LocalTime.hxx>
#include <StepBasic_Organization.hxx>
#include <StepBasic_Person.hxx>
#include <StepBasic_PersonAndOrganization.hxx>
#include <StepBasic_Product.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <TCollection_HAsciiString.hxx>
#include <XSControl_Controller.hxx>
#include <XSControl_WorkSession.hxx>
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <sstream>

namespace patchwright::occ {

namespace {

/// A private member of the kernel's, which explicit instantiations may name.
template <STEPConstruct_ContextTool STEPControl_ActorWrite::*Member>
struct ContextOf {
    friend STEPConstruct_ContextTool& context_of(STEPControl_ActorWrite& actor) {
        return actor.*Member;
    }
};
template struct ContextOf<&STEPControl_ActorWrite::myContext>;
STEPConstruct_ContextTool& context_of(STEPControl_ActorWrite& actor);

using Path = std::filesystem::path;

/// The kernel's names of the units, for STEP and for IGES.
const char* kernel_unit(base::LengthUnit unit) {
    switch (unit) {
        case base::LengthUnit::Millimetre: return "MM";
        case base::LengthUnit::Centimetre: return "CM";
        case base::LengthUnit::Metre: return "M";
        case base::LengthUnit::Inch: return "INCH";
        case base::LengthUnit::Foot: return "FT";
    }
    return "MM";
}

int kernel_schema(StepSchema schema) {
    switch (schema) {
        case StepSchema::Ap203: return 3;
        case StepSchema::Ap214: return 4;  // AP214IS
        case StepSchema::Ap242: return 5;  // AP242DIS
    }
    return 4;
}

[[noreturn]] void refuse(const Path& path, const char* what) {
    throw base::OutputError(fmt::format("{}: the CAD kernel could not {}", path.string(), what));
}

Handle(TCollection_HAsciiString) kernel_string(const std::string& text) {
    return new TCollection_HAsciiString(text.c_str());
}

/// What identifies us in a file; unless asked for, the time is a fixed one so that equal models
/// give equal bytes.
struct Signature {
    explicit Signature(bool time_stamp) {
        const std::time_t now = time_stamp ? std::time(nullptr) : 0;
        const std::tm utc = *std::gmtime(&now);
        step_time = fmt::format("{:%Y-%m-%dT%H:%M:%S}", utc);
        iges_time = fmt::format("{:%Y%m%d.%H%M%S}", utc);
    }
    std::string system = fmt::format("patchwright {}", base::version());
    std::string step_time, iges_time;
};

Handle(StepBasic_PersonAndOrganization) unknown_author() {
    const Handle(StepBasic_Person) person = new StepBasic_Person;
    person->Init(kernel_string("unknown"), Standard_True, kernel_string(""), Standard_False, {},
                 Standard_False, {}, Standard_False, {}, Standard_False, {});
    const Handle(StepBasic_Organization) organization = new StepBasic_Organization;
    organization->Init(Standard_True, kernel_string("unknown"), kernel_string("unspecified"), {});
    Handle(StepBasic_PersonAndOrganization) both = new StepBasic_PersonAndOrganization;
    both->Init(person, organization);
    return both;
}

/// AP203 asks for a person and an organisation. The kernel would make them of the user's name and
/// the host's address, and crashes where the host's name has none. It keeps approvals that name
/// them from one file to the next, so they are the same for all.
void set_author(STEPControl_Writer& writer) {
    static const Handle(StepBasic_PersonAndOrganization) author = unknown_author();
    const auto actor =
        Handle(STEPControl_ActorWrite)::DownCast(writer.WS()->NormAdaptor()->ActorWrite());
    context_of(*actor).AP203Context().SetDefaultPersonAndOrganization(author);
}

/// The kernel numbers products by process, and AP203 asks for dates, for which it takes the
/// clock's: fixed values, so that equal models give equal bytes.
void fix_administration(const Handle(StepData_StepModel) & step, const std::string& name) {
    for (int i = 1; i <= step->NbEntities(); ++i) {
        const Handle(Standard_Transient) entity = step->Entity(i);
        if (const auto product = Handle(StepBasic_Product)::DownCast(entity); !product.IsNull()) {
            product->SetId(kernel_string(name));
            product->SetName(kernel_string(name));
        } else if (const auto date = Handle(StepBasic_CalendarDate)::DownCast(entity);
                   !date.IsNull()) {
            date->SetYearComponent(1970);
            date->SetMonthComponent(1);
            date->SetDayComponent(1);
        } else if (const auto time = Handle(StepBasic_LocalTime)::DownCast(entity);
                   !time.IsNull()) {
            time->SetHourComponent(0);
            time->SetMinuteComponent(0);
            time->SetSecondComponent(0.0);
        }
    }
}

/// Deeper knots make control points so dense that the kernel's 12 to 13 digits turn normals.
constexpr double knot_step_of_plain_digits = 1.0 / 16.0;

double smallest_knot_step(const CadModel& model) {
    double smallest = 1.0;
    for (const TopoDS_Face& face : faces_of(model)) {
        const auto surface = Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(face));
        if (surface.IsNull()) continue;
        for (int k = 1; k < surface->NbUKnots(); ++k) {
            smallest = std::min(smallest, surface->UKnot(k + 1) - surface->UKnot(k));
        }
        for (int k = 1; k < surface->NbVKnots(); ++k) {
            smallest = std::min(smallest, surface->VKnot(k + 1) - surface->VKnot(k));
        }
    }
    return smallest;
}

std::string step_file(const CadModel& model, const Path& target, const WriteOptions& options) {
    ExchangeSession session;
    const std::string name = options.name.value_or(target.stem().string());
    session.set("write.step.schema", kernel_schema(options.schema));
    session.set("write.step.unit", kernel_unit(options.unit));
    session.set("write.step.product.name", name);
    // Without p-curves the kernel's reader misses some of the split sides by 4e-9 of the diagonal.
    session.set("write.surfacecurve.mode", 1);
    STEPControl_Writer writer;
    set_author(writer);
    if (writer.Transfer(model.impl().shape, STEPControl_AsIs) != IFSelect_RetDone) {
        refuse(target, "translate the model to STEP");
    }
    write_step_attributes(writer, model);
    if (options.schema == StepSchema::Ap242) add_validation_properties(writer, model);
    fix_administration(writer.Model(), name);
    const Signature signature(options.time_stamp);
    APIHeaderSection_MakeHeader header(writer.Model());
    header.SetName(kernel_string(name));
    header.SetTimeStamp(kernel_string(signature.step_time));
    header.SetAuthorValue(1, kernel_string(""));
    header.SetOrganizationValue(1, kernel_string(""));
    header.SetOriginatingSystem(kernel_string(signature.system));
    header.SetPreprocessorVersion(kernel_string(signature.system));
    header.SetDescriptionValue(1, kernel_string("untrimmed bicubic B-spline patches"));
    StepData_StepWriter text(writer.Model());
    if (smallest_knot_step(model) < knot_step_of_plain_digits) {
        text.FloatWriter().SetFormat("%.15E");
        text.FloatWriter().SetFormatForRange("%.15f", 0.1, 1000.0);
    }
    text.SendModel(Handle(StepData_Protocol)::DownCast(writer.WS()->Protocol()));
    std::ostringstream stream;
    if (!text.Print(stream)) refuse(target, "write the model as STEP");
    return compact_step(encode_step_text(stream.str()));
}

std::string iges_file(const CadModel& model, const Path& target, const WriteOptions& options) {
    ExchangeSession session;
    // Mode 1: B-rep entities with shared edges, not independent trimmed faces.
    IGESControl_Writer writer(
        options.unit == base::LengthUnit::Inch ? "IN" : kernel_unit(options.unit), 1);
    if (!writer.AddShape(model.impl().shape)) refuse(target, "translate the model to IGES");
    write_iges_attributes(writer, model);
    writer.ComputeModel();
    const Signature signature(options.time_stamp);
    IGESData_GlobalSection global = writer.Model()->GlobalSection();
    const std::string name = options.name.value_or(target.stem().string());
    global.SetSendName(kernel_string(name));
    global.SetReceiveName(kernel_string(name));
    global.SetFileName(kernel_string(name + target.extension().string()));
    global.SetSystemId(kernel_string(signature.system));
    global.SetInterfaceVersion(kernel_string(signature.system));
    global.SetDate(kernel_string(signature.iges_time));
    global.SetLastChangeDate(kernel_string(signature.iges_time));
    global.SetAuthorName(kernel_string(""));
    global.SetCompanyName(kernel_string(""));
    writer.Model()->SetGlobalSection(global);
    std::ostringstream stream;
    if (!writer.Write(stream)) refuse(target, "write the model as IGES");
    return stream.str();
}

std::string brep_file(const CadModel& model, const Path& target) {
    std::ostringstream stream;
    BRepTools::Write(model.impl().shape, stream);
    if (!stream) refuse(target, "write the model as BREP");
    return stream.str();
}

}  // namespace

void write_cad(const CadModel& model, base::PendingFile& file, const WriteOptions& options) {
    const Path& target = file.target().given;
    const std::string content = guard_kernel<base::OutputError>(target.string(), [&] {
        switch (file_format(target)) {
            case FileFormat::Step: return step_file(model, target, options);
            case FileFormat::Iges: return iges_file(model, target, options);
            case FileFormat::Brep: return brep_file(model, target);
        }
        return std::string();
    });
    file.write(content);
}

void write_cad(const CadModel& model, const Path& path, const WriteOptions& options) {
    base::OutputSet outputs;
    const auto file = std::make_shared<base::PendingFile>(path);
    write_cad(model, *file, options);
    outputs.add(file);
    outputs.commit();
}

}  // namespace patchwright::occ
