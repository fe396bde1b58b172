#include "modes.h"

#include "arrays.h"
#include "cage.h"
#include "call.h"

#include <patchwright/fit/modes.h>

#include <pybind11/stl.h>

namespace patchwright::python {

namespace {

/// Mean (n, 3), shapes (modes, n, 3), weights (members, modes), standard deviations, variance.
py::tuple principal_modes(const PyCage& cage, const std::vector<Doubles>& given, int count) {
    std::vector<geom::Points> members;
    for (const Doubles& points : given) members.push_back(points_of(points));
    fit::Modes modes = Call(py::none()).run("members", [&] {
        return fit::principal_modes(cage.shared_topology(), members, count);
    });
    const py::ssize_t n = modes.mean.rows(), k = modes.count();
    std::vector<double> shapes, weights;
    for (const geom::Points& shape : modes.shapes)
        shapes.insert(shapes.end(), shape.data(), shape.data() + shape.size());
    for (Eigen::Index i = 0; i < modes.weights.rows(); ++i)
        for (Eigen::Index j = 0; j < modes.weights.cols(); ++j)
            weights.push_back(modes.weights(i, j));
    return py::make_tuple(take(std::move(modes.mean)), take<double>(std::move(shapes), {k, n, 3}),
                          take<double>(std::move(weights), {py::ssize_t(members.size()), k}),
                          take<double>(std::move(modes.deviations_mm), {k}), modes.variance_mm2);
}

}  // namespace

void bind_modes(py::module_& module) { module.def("principal_modes", principal_modes); }

}  // namespace patchwright::python
