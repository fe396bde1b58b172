// NumPy arrays from the library's containers and back.
#pragma once

#include <patchwright/base/error.h>
#include <patchwright/geom/types.h>

#include <pybind11/numpy.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace patchwright::python {

namespace py = pybind11;

/// Contiguous; the module's Python code has converted and named what does not fit.
using Doubles = py::array_t<double, py::array::c_style>;
using Integers = py::array_t<std::int32_t, py::array::c_style>;

/// An array that owns `values`, which are not copied.
template <class T, class Container>
py::array_t<T> take(Container&& values, std::vector<py::ssize_t> shape) {
    auto* held = new Container(std::forward<Container>(values));
    const py::capsule owner(held, [](void* p) { delete static_cast<Container*>(p); });
    return py::array_t<T>(std::move(shape), reinterpret_cast<const T*>(held->data()), owner);
}

inline py::array_t<double> take(geom::Points&& points) {
    const py::ssize_t rows = points.rows();
    return take<double>(std::move(points), {rows, 3});
}

template <class T, int flags>
std::span<const T> span_of(const py::array_t<T, flags>& values) {
    return {values.data(), std::size_t(values.size())};
}

/// @throw UsageError when the array is not n x 3
inline geom::Points points_of(const Doubles& values) {
    if (values.ndim() != 2 || values.shape(1) != 3)
        throw base::UsageError("points are an array of shape (n, 3)");
    return Eigen::Map<const geom::Points>(values.data(), values.shape(0), 3);
}

}  // namespace patchwright::python
