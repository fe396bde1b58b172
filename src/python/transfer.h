// Values carried between a structural model's points and a cage's.
#pragma once

#include <pybind11/pybind11.h>

namespace patchwright::python {

void bind_transfer(pybind11::module_& module);

}  // namespace patchwright::python
