// NumPy arrays from the library's containers and back.
#pragma once

#include <patchwright/base/error.h>
#include <patchwright/geom/types.h>

#include <pybind11/numpy.h>

#include <algorithm>
#include <cstdint>
#include <memory>
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

/// The same memory, which it keeps: n x 3.
/// @throw UsageError when the array is not n x 3
inline Doubles view(const Doubles& values) {
    if (values.ndim() != 2 || values.shape(1) != 3)
        throw base::UsageError("points are an array of shape (n, 3)");
    return Doubles({values.shape(0), values.shape(1)}, values.data(), values);
}

/// An array that cannot be written to, of values that belong to `owner`.
template <class T, class Owner>
py::array_t<T> view(std::span<const T> values, std::shared_ptr<Owner> owner) {
    auto* held = new std::shared_ptr<Owner>(std::move(owner));
    const py::capsule keeper(held, [](void* p) { delete static_cast<std::shared_ptr<Owner>*>(p); });
    py::array_t<T> array(py::ssize_t(values.size()), values.data(), keeper);
    array.attr("flags").attr("writeable") = false;
    return array;
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
