#include "occ/exchange/find_fault.h"

#include "occ/exchange/exchange_session.h"
#include "occ/exchange/face_entities.h"
#include "occ/exchange/file_checks.h"
#include "occ/kernel_guard.h"

#include <patchwright/occ/cad_model.h>

#include <IGESControl_Reader.hxx>
#include <IGESData_IGESModel.hxx>
#include <STEPControl_Reader.hxx>
#include <StepData_StepModel.hxx>

namespace patchwright::occ {

namespace {

using Tell = std::function<void(const std::string&)>;

void transfer_each(XSControl_Reader& reader, const std::vector<FaceEntity>& faces,
                   const Tell& tell) {
    for (const FaceEntity& face : faces) {
        tell(face.label + " " + face.type);
        try {
            reader.TransferEntity(face.entity);
        } catch (const Standard_Failure&) {
            // An error that the kernel tells of is not what is looked for.
        }
    }
    tell("");
}

}  // namespace

void find_fault(const std::filesystem::path& path, const Tell& tell) {
    const FileFormat format = file_format(path);
    guard_kernel<base::InputError>(path.string(), [&] {
        if (format == FileFormat::Step) {
            const std::string text = check_step_file(path);
            const ExchangeSession session;
            STEPControl_Reader reader;
            reader.ReadFile(path.c_str());
            transfer_each(reader, step_faces(reader.StepModel(), text), tell);
        } else if (format == FileFormat::Iges) {
            check_iges_file(path);
            const ExchangeSession session;
            IGESControl_Reader reader;
            reader.ReadFile(path.c_str());
            transfer_each(reader, iges_faces(reader.IGESModel()), tell);
        }
    });
}

}  // namespace patchwright::occ
