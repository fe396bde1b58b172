// Principal components of families of cages.
#pragma once

#include <pybind11/pybind11.h>

namespace patchwright::python {

void bind_modes(pybind11::module_& module);

}  // namespace patchwright::python
