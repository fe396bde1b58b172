// The entities of a file that are to give faces.
#pragma once

#include <Standard_Handle.hxx>
#include <Standard_Transient.hxx>

#include <string>
#include <string_view>
#include <vector>

class IGESData_IGESModel;
class StepData_StepModel;

namespace patchwright::occ {

struct FaceEntity {
    Handle(Standard_Transient) entity;
    std::string label;  ///< as the file numbers it: "#17" in STEP, directory entry "D17" in IGES
    std::string type;   ///< "ADVANCED_FACE", "144 trimmed surface"
};

/// Faces only, in the order of the file.
/// @param text  the file
std::vector<FaceEntity> step_faces(const Handle(StepData_StepModel) & model, std::string_view text);

/// Faces and solids, and surfaces that serve nothing else.
std::vector<FaceEntity> iges_faces(const Handle(IGESData_IGESModel) & model);

}  // namespace patchwright::occ
