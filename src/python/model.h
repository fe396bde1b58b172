// Models that were read, as Python sees them.
#pragma once

#include <patchwright/convert/source.h>

#include <pybind11/pybind11.h>

#include <memory>

namespace patchwright::python {

/// What a file holds; calls that compare or convert it more than once read it only once.
struct PyModel {
    std::shared_ptr<const convert::Source> source;
};

void bind_model(pybind11::module_& module);

}  // namespace patchwright::python
