#include "model.h"

#include "arrays.h"
#include "call.h"
#include "options.h"

#include <patchwright/base/parallel.h>
#include <patchwright/measure/field.h>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <mutex>
#include <system_error>

namespace patchwright::python {

namespace {

namespace fs = std::filesystem;

/// The program that reads CAD files for this process, which the kernel may bring down. A program of
/// its own: interpreters have threads, and a copy of a process with threads may wait for ever.
class Reader {
  public:
    /// Not the one of another process of which this is a copy, nor one in another folder, from
    /// which relative paths lead elsewhere.
    std::shared_ptr<occ::ReaderProcess> get() {
        const std::lock_guard lock(mutex_);
        const fs::path folder = fs::current_path();
        if (!process_ || owner_ != ::getpid() || folder_ != folder) {
            process_ = std::make_shared<occ::ReaderProcess>(program);
            owner_ = ::getpid();
            folder_ = folder;
        }
        return process_;
    }

    /// The next call starts another one.
    void forget() {
        const std::lock_guard lock(mutex_);
        process_.reset();
    }

    fs::path program;  ///< beside the module

  private:
    std::mutex mutex_;
    std::shared_ptr<occ::ReaderProcess> process_;  // calls that read have it too
    pid_t owner_ = 0;
    fs::path folder_;
};

Reader& reader() {
    static Reader the_reader;
    return the_reader;
}

PyModel read_model(const std::string& file, const py::dict& given, py::object progress) {
    const Options options(given);
    convert::SourceOptions reading{.allow_loss = options.flag("allow_loss"),
                                   .heal = options.flag("heal")};
    if (const auto unit = options.text("input_unit")) reading.unit = base::parse_length_unit(*unit);
    if (const auto degrees = options.number("sharp_angle", 0.1, 179.0))
        reading.sharp_angle_rad = *degrees * M_PI / 180.0;
    reading.foot_points = options.choice<occ::FootPoints>(
        "foot_points", {{"search", occ::FootPoints::Search}, {"kernel", occ::FootPoints::Kernel}});
    reading.limits.time_s = options.number("read_limit", 1e-9, 1e7);
    Call call(std::move(progress));
    return call.run(file, [&] {
        const std::shared_ptr<occ::ReaderProcess> process = reader().get();
        reading.reader = process.get();
        reading.progress = call.progress();
        const auto source = std::make_shared<convert::Source>();
        try {
            *source = convert::read_source(file, reading);
        } catch (const std::system_error&) {
            reader().forget();  // somebody has ended it
            throw;
        }
        // Ends with this call; what is read is used by others.
        source->options.progress = {};
        source->options.reader = nullptr;
        return PyModel{source};
    });
}

void write_cad(const PyModel& model, const fs::path& file, const std::string& unit) {
    if (!model.source->model)
        throw base::UsageError(model.source->input.file +
                               ": triangles are no CAD model that could be written");
    occ::write_cad(*model.source->model, file, {.unit = base::parse_length_unit(unit)});
}

py::dict field_arrays(measure::Field&& field) {
    using namespace py::literals;
    const auto vertices = field.points.rows();
    const auto triangles = py::ssize_t(field.triangles.size());
    py::dict result("points"_a = take(std::move(field.points)),
                    "normals"_a = take(std::move(field.normals)),
                    "triangles"_a = take<std::int32_t>(std::move(field.triangles), {triangles, 3}),
                    "faces"_a = take<std::int32_t>(std::move(field.faces), {triangles}),
                    "curvature"_a = take<double>(std::move(field.curvature), {vertices}));
    if (!field.distance_mm.empty()) {
        result["deviation"] = take<double>(std::move(field.distance_mm), {vertices});
        result["normal_angle"] = take<double>(std::move(field.normal_angle_rad), {vertices});
    }
    return result;
}

py::dict field_of(const PyModel& model, const std::optional<PyModel>& other, py::object progress) {
    Call call(std::move(progress));
    measure::Field found = call.run(model.source->input.file, [&] {
        return measure::measure_field(model.source->surface(),
                                      other ? &other->source->surface() : nullptr,
                                      {.progress = call.progress()});
    });
    return field_arrays(std::move(found));
}

py::tuple foot_points(const PyModel& model, const Doubles& values) {
    const geom::Points queries = points_of(values);
    if (!queries.allFinite()) throw base::UsageError("a point is not finite");
    geom::Points points(queries.rows(), 3);
    std::vector<double> distances(static_cast<std::size_t>(queries.rows()));
    Call(py::none()).run(model.source->input.file, [&] {
        const geom::ModelSurface& surface = model.source->surface();
        constexpr std::size_t grain = 64;  // about a millisecond
        base::parallel_for(distances.size(), grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const geom::FootPoint foot =
                    surface.foot_point(queries.row(Eigen::Index(i)).transpose());
                points.row(Eigen::Index(i)) = foot.point.transpose();
                distances[i] = foot.distance;
            }
        });
        return 0;
    });
    const auto count = py::ssize_t(distances.size());
    return py::make_tuple(take(std::move(points)), take<double>(std::move(distances), {count}));
}

}  // namespace

void bind_model(py::module_& module) {
    module.def("set_reader", [](const fs::path& program) { reader().program = program; });
    module.def("read", read_model);
    module.def("field", field_of);
    py::class_<PyModel>(module, "Model")
        .def_property_readonly("file", [](const PyModel& m) { return m.source->input.file; })
        .def_property_readonly(
            "unit",
            [](const PyModel& m) { return std::string(base::short_name(m.source->input.unit)); })
        .def_property_readonly("diagonal",
                               [](const PyModel& m) { return m.source->input.diagonal; })
        .def_property_readonly("is_cad",
                               [](const PyModel& m) { return m.source->model.has_value(); })
        .def_property_readonly("notices", [](const PyModel& m) { return m.source->notices; })
        .def("write_cad", write_cad)
        .def("foot_points", foot_points);
}

}  // namespace patchwright::python
