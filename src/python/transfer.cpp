#include "transfer.h"

#include "arrays.h"
#include "cage.h"
#include "call.h"

#include <patchwright/fit/morph.h>

#include <fmt/format.h>

namespace patchwright::python {

namespace {

using fit::PointTransfer;

PointTransfer make_transfer(const Doubles& from, const Doubles& to) {
    const geom::Points points = points_of(from), targets = points_of(to);
    return Call(py::none()).run("points", [&] {
        return PointTransfer(points, targets, [](int i) { return fmt::format("point {}", i); });
    });
}

void check_rows(const geom::Points& values, int rows) {
    if (values.rows() != rows)
        throw base::UsageError(fmt::format("values: {} rows for {} points", values.rows(), rows));
}

py::array apply(const PointTransfer& transfer, const Doubles& given) {
    const geom::Points values = points_of(given);
    check_rows(values, transfer.columns());
    return take(Call(py::none()).run("values", [&] { return transfer.apply(values); }));
}

py::array apply_transposed(const PointTransfer& transfer, const Doubles& given) {
    const geom::Points values = points_of(given);
    check_rows(values, transfer.rows());
    return take(Call(py::none()).run("values", [&] { return transfer.apply_transposed(values); }));
}

PyCage morph(const PyCage& given, const PointTransfer& transfer, const Doubles& displacements) {
    const mesh::Cage cage = given.checked();
    const geom::Points values = points_of(displacements);
    check_rows(values, transfer.columns());
    if (transfer.rows() != cage.points.rows())
        throw base::UsageError(fmt::format("the transfer goes to {} points, the cage has {}",
                                           transfer.rows(), cage.points.rows()));
    mesh::Cage moved =
        Call(py::none()).run("cage", [&] { return fit::morph(cage, transfer, values); });
    if (!(moved.points.cwiseAbs().maxCoeff() <= geom::largest_coordinate))
        throw base::UsageError(fmt::format("displacements: move control points beyond {:g}",
                                           geom::largest_coordinate));
    return PyCage(std::move(moved));
}

}  // namespace

void bind_transfer(py::module_& module) {
    py::class_<PointTransfer>(module, "PointTransfer")
        .def_static("build", make_transfer)
        .def("rows", &PointTransfer::rows)
        .def("columns", &PointTransfer::columns)
        .def("apply", apply)
        .def("apply_transposed", apply_transposed)
        .def("extrapolation", &PointTransfer::extrapolation);
    module.def("morph", morph);
}

}  // namespace patchwright::python
