#include "make_files.h"

#include <APIHeaderSection_MakeHeader.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <TCollection_HAsciiString.hxx>

#include <stdexcept>

namespace cad_files {

namespace {

Handle(TCollection_HAsciiString) text(const std::string& s) {
    return new TCollection_HAsciiString(s.c_str());
}

}  // namespace

void write_step(const TopoDS_Shape& shape, const std::string& path, const Header& header) {
    STEPControl_Controller::Init();
    Interface_Static::SetCVal("write.step.schema", "AP214IS");
    Interface_Static::SetCVal("write.step.unit", "MM");
    Interface_Static::SetCVal("write.step.product.name", header.product.c_str());
    STEPControl_Writer writer;
    if (writer.Transfer(shape, STEPControl_AsIs) != IFSelect_RetDone)
        throw std::runtime_error(path + ": not translated");
    APIHeaderSection_MakeHeader section(writer.Model());
    section.SetName(text(header.file));
    section.SetTimeStamp(text("2000-01-01T00:00:00"));
    section.SetAuthorValue(1, text("patchwright"));
    section.SetOrganizationValue(1, text("patchwright"));
    section.SetOriginatingSystem(text(header.program));
    if (writer.Write(path.c_str()) != IFSelect_RetDone)
        throw std::runtime_error(path + ": not written");
}

void write_iges(const std::vector<TopoDS_Face>& faces, const std::string& path,
                const Header& header, const char* unit) {
    IGESControl_Controller::Init();
    IGESControl_Writer writer(unit, 0);
    for (const auto& face : faces) {
        if (!writer.AddShape(face)) throw std::runtime_error(path + ": a face is not translated");
    }
    IGESData_GlobalSection global = writer.Model()->GlobalSection();
    global.SetFileName(text(header.file));
    global.SetSendName(text(header.product));
    global.SetSystemId(text(header.program));
    global.SetAuthorName(text("patchwright"));
    global.SetDate(text("20000101.000000"));
    global.SetLastChangeDate(text("20000101.000000"));
    writer.Model()->SetGlobalSection(global);
    writer.ComputeModel();
    if (!writer.Write(path.c_str())) throw std::runtime_error(path + ": not written");
}

void silence_kernel() {
    Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
}

}  // namespace cad_files
