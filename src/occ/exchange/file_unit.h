// The unit that the lengths of a file are in.
#pragma once

#include <Standard_Handle.hxx>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

class IGESData_IGESModel;
class StepData_StepModel;

namespace patchwright::occ {

struct FileUnit {
    /// What the kernel takes a length of the file times; of the first part where parts differ.
    double millimetres = 1.0;
    bool differs = false;                ///< other parts of the file have other units
    std::optional<std::string> problem;  ///< why nobody knows: "names no unit of length"
};

/// @param text  the file
FileUnit step_unit(const Handle(StepData_StepModel) & model, std::string_view text);

/// An unknown flag becomes millimetres in the model: the kernel would multiply by zero.
FileUnit iges_unit(const Handle(IGESData_IGESModel) & model, const std::string& text);

}  // namespace patchwright::occ
