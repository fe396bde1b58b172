// Structured grids for Python.
#pragma once

#include <pybind11/pybind11.h>

namespace patchwright::python {

void bind_grids(pybind11::module_& module);

}  // namespace patchwright::python
