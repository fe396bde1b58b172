// What the command line's subcommands do, for Python.
#pragma once

#include <pybind11/pybind11.h>

namespace patchwright::python {

void bind_runs(pybind11::module_& module);

}  // namespace patchwright::python
