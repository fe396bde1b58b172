#include "cage.h"

#include "call.h"

#include <patchwright/base/output_set.h>
#include <patchwright/base/units.h>
#include <patchwright/mesh/obj.h>
#include <patchwright/subd/normal_control.h>
#include <patchwright/subd/refine.h>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>

namespace patchwright::python {

namespace {

/// @throw UsageError unless the array has this many columns
void check_columns(const py::array& values, const char* name, py::ssize_t columns) {
    if (values.ndim() != 2 || values.shape(1) != columns)
        throw base::UsageError(std::string(name) + " are an array of shape (n, " +
                               std::to_string(columns) + ")");
}

/// Tags as arrays of vertex numbers, one row a tag, and their sharpnesses.
struct Tags {
    Integers creases, corners;
    Doubles crease_sharpness, corner_sharpness;
    Integers pins;
    bool boundary_corners = false, runout = false;
};

void add_tags(mesh::TopologyInput& input, const Tags& tags) {
    check_columns(tags.creases, "creases", 2);
    if (tags.creases.shape(0) != tags.crease_sharpness.size() ||
        tags.corners.size() != tags.corner_sharpness.size())
        throw base::UsageError("there is one sharpness a crease, and one a corner");
    const auto edges = span_of(tags.creases);
    for (std::size_t i = 0; i < std::size_t(tags.creases.shape(0)); ++i)
        input.creases.push_back(
            {edges[2 * i], edges[2 * i + 1], span_of(tags.crease_sharpness)[i]});
    for (std::size_t i = 0; i < std::size_t(tags.corners.size()); ++i)
        input.corners.push_back({span_of(tags.corners)[i], span_of(tags.corner_sharpness)[i]});
    const auto pins = span_of(tags.pins);
    input.pins.assign(pins.begin(), pins.end());
    input.boundary_rule =
        tags.boundary_corners ? mesh::BoundaryRule::EdgeAndCorner : mesh::BoundaryRule::EdgeOnly;
    input.crease_rule =
        tags.runout ? mesh::CreaseRule::ParabolicRunout : mesh::CreaseRule::CatmullClark;
}

PyCage build(const Doubles& points, const Integers& sizes, const Integers& vertices,
             const Tags& tags, std::vector<std::string> group_names, const Integers& groups) {
    mesh::TopologyInput input;
    check_columns(points, "points", 3);
    input.vertex_count = int(points.shape(0));
    const auto copy = [](const Integers& from, std::vector<int>& to) {
        to.assign(from.data(), from.data() + from.size());
    };
    copy(sizes, input.face_sizes);
    copy(vertices, input.face_vertices);
    copy(groups, input.face_group);
    input.group_names = std::move(group_names);
    std::int64_t corners = 0;
    for (const int size : input.face_sizes) {
        if (size < 3) throw base::UsageError("a face has three vertices or more");
        corners += size;
    }
    if (corners != vertices.size())
        throw base::UsageError("the faces' sizes do not add up to the number of their vertices");
    if (!input.face_group.empty() && input.face_group.size() != input.face_sizes.size())
        throw base::UsageError("there is one group a face");
    for (const int group : input.face_group)
        if (group < -1 || group >= int(input.group_names.size()))
            throw base::UsageError("group " + std::to_string(group) + " has no name");
    add_tags(input, tags);
    mesh::BuildResult built = mesh::build_cage(std::move(input), points_of(points));
    if (built.removed_vertices > 0) return PyCage(std::move(built.cage));
    return {std::move(built.cage.topology), points};
}

PyCage read_cage(const std::filesystem::path& file, const std::string& unit) {
    const double scale = base::millimetres_per(base::parse_length_unit(unit));
    mesh::Cage cage = mesh::read_obj(file).cage;
    cage.points *= scale;
    return PyCage(std::move(cage));
}

void write_cage(const PyCage& cage, const std::filesystem::path& file, const std::string& unit) {
    mesh::Cage scaled = cage.checked();
    scaled.points /= base::millimetres_per(base::parse_length_unit(unit));
    base::OutputSet outputs;
    outputs.add(file, mesh::obj_text(scaled));
    outputs.commit();
}

py::tuple faces(const PyCage& cage) {
    const mesh::Topology& topology = cage.topology();
    std::vector<std::int32_t> sizes;
    for (const mesh::FaceId f : topology.faces()) sizes.push_back(topology.size(f));
    const auto count = py::ssize_t(sizes.size());
    py::array vertices = view(topology.face_vertices(), cage.shared_topology());
    return py::make_tuple(take<std::int32_t>(std::move(sizes), {count}), std::move(vertices));
}

py::tuple creases(const PyCage& cage) {
    const mesh::Topology& topology = cage.topology();
    std::vector<std::int32_t> edges;
    std::vector<double> sharpness;
    for (const mesh::EdgeId e : topology.edges()) {
        if (!(topology.tagged_sharpness(e) > 0.0)) continue;
        edges.push_back(topology.start(e).value);
        edges.push_back(topology.end(e).value);
        sharpness.push_back(topology.tagged_sharpness(e));
    }
    const auto count = py::ssize_t(sharpness.size());
    return py::make_tuple(take<std::int32_t>(std::move(edges), {count, 2}),
                          take<double>(std::move(sharpness), {count}));
}

py::tuple corners(const PyCage& cage) {
    const mesh::Topology& topology = cage.topology();
    std::vector<std::int32_t> vertices;
    std::vector<double> sharpness;
    for (const mesh::VertexId v : topology.vertices()) {
        if (!(topology.tagged_sharpness(v) > 0.0)) continue;
        vertices.push_back(v.value);
        sharpness.push_back(topology.tagged_sharpness(v));
    }
    const auto count = py::ssize_t(vertices.size());
    return py::make_tuple(take<std::int32_t>(std::move(vertices), {count}),
                          take<double>(std::move(sharpness), {count}));
}

py::array_t<std::int32_t> pins(const PyCage& cage) {
    std::vector<std::int32_t> vertices;
    for (const mesh::VertexId v : cage.topology().vertices())
        if (cage.topology().is_pinned(v)) vertices.push_back(v.value);
    const auto count = py::ssize_t(vertices.size());
    return take<std::int32_t>(std::move(vertices), {count});
}

py::dict summary(const PyCage& cage) {
    const mesh::CageSummary s = mesh::summarise(cage.topology());
    using namespace py::literals;
    return py::dict("vertices"_a = s.vertices, "faces"_a = s.faces, "non_quads"_a = s.non_quads,
                    "extraordinary"_a = s.extraordinary, "creases"_a = s.creases,
                    "corners"_a = s.corners, "boundary_edges"_a = s.boundary_edges,
                    "pins"_a = s.pins);
}

subd::Locations locations(const Integers& faces, const Doubles& uv, const Integers& sectors) {
    check_columns(uv, "parameters", 2);
    return {span_of(faces), span_of(uv), span_of(sectors)};
}

py::array evaluate(PyCage& cage, const Integers& faces, const Doubles& uv, const Integers& sectors,
                   int order) {
    const subd::Locations at = locations(faces, uv, sectors);
    mesh::Cage own = cage.checked();
    const auto evaluator = cage.evaluator();
    geom::Points points = Call(py::none()).run("cage", [&] {
        if (!own.topology->sectors().empty()) own = subd::control_normals(own);
        return evaluator->evaluate(own.points, at, order);
    });
    const auto count = py::ssize_t(at.size());
    if (order == 0) return take(std::move(points));
    return take<double>(std::move(points), {count, subd::row_count(order), 3});
}

py::tuple masks(PyCage& cage, const Integers& faces, const Doubles& uv, const Integers& sectors,
                int order) {
    const subd::Locations at = locations(faces, uv, sectors);
    const auto evaluator = cage.evaluator();
    subd::Stencils rows = Call(py::none()).run("cage", [&] { return evaluator->masks(at, order); });
    const auto count = py::ssize_t(rows.weight.size()), ends = py::ssize_t(rows.begin.size());
    return py::make_tuple(take<double>(std::move(rows.weight), {count}),
                          take<std::int32_t>(std::move(rows.index), {count}),
                          take<std::int64_t>(std::move(rows.begin), {ends}));
}

py::array smoothness(PyCage& cage, const Integers& faces, const Doubles& uv,
                     const Integers& sectors) {
    const std::vector<subd::Smoothness> found =
        cage.evaluator()->smoothness(locations(faces, uv, sectors));
    std::vector<std::uint8_t> values;
    for (const subd::Smoothness s : found)
        values.push_back(s == subd::Smoothness::Derivatives    ? 2
                         : s == subd::Smoothness::TangentPlane ? 1
                                                               : 0);
    const auto count = py::ssize_t(values.size());
    return take<std::uint8_t>(std::move(values), {count});
}

PyCage refined_cage(const PyCage& cage, int levels) {
    constexpr int most_levels = 12;  // of one face: 16 million
    if (levels < 0 || levels > most_levels)
        throw base::UsageError("levels: " + std::to_string(levels) + " is no number from 0 to " +
                               std::to_string(most_levels));
    const mesh::Cage own = cage.checked();
    return PyCage(Call(py::none()).run("cage", [&] { return subd::refine(own, levels); }));
}

}  // namespace

PyCage::PyCage(mesh::Cage cage)
    : topology_(std::move(cage.topology)), points_(take(std::move(cage.points))) {}

PyCage::PyCage(std::shared_ptr<const mesh::Topology> topology, const Doubles& points)
    : topology_(std::move(topology)), points_(view(points)) {
    if (points_.shape(0) != topology_->vertex_count())
        throw base::UsageError(std::to_string(points_.shape(0)) + " points for " +
                               std::to_string(topology_->vertex_count()) + " vertices");
}

mesh::Cage PyCage::checked() const {
    geom::Points points = points_of(points_);
    if (!(points.array().abs() <= geom::largest_coordinate).all())
        throw base::UsageError("a point of the cage is not finite");
    return {topology_, std::move(points)};
}

Doubles PyCage::points() const { return view(points_); }

PyCage PyCage::with_points(const Doubles& points) const {
    PyCage other(topology_, points);
    other.evaluator_ = evaluator_;
    return other;
}

std::shared_ptr<const subd::LimitEvaluator> PyCage::evaluator() {
    if (!evaluator_) evaluator_ = std::make_shared<const subd::LimitEvaluator>(topology_);
    return evaluator_;
}

void bind_cage(py::module_& module) {
    py::class_<PyCage>(module, "Cage")
        .def_static(
            "build",
            [](const Doubles& points, const Integers& sizes, const Integers& vertices,
               const Integers& creases, const Doubles& crease_sharpness, const Integers& corners,
               const Doubles& corner_sharpness, const Integers& pins, bool boundary_corners,
               bool runout, std::vector<std::string> group_names, const Integers& groups) {
                return build(points, sizes, vertices,
                             {creases, corners, crease_sharpness, corner_sharpness, pins,
                              boundary_corners, runout},
                             std::move(group_names), groups);
            })
        .def_static("read", read_cage)
        .def("write", write_cage)
        .def("copy",
             [](const PyCage& cage) { return cage.with_points(take(cage.checked().points)); })
        .def("with_points", &PyCage::with_points)
        .def_property_readonly("points", &PyCage::points)
        .def("faces", faces)
        .def("creases", creases)
        .def("corners", corners)
        .def("pins", pins)
        .def("has_runout_rule",
             [](const PyCage& cage) {
                 return cage.topology().crease_rule() == mesh::CreaseRule::ParabolicRunout;
             })
        .def("groups",
             [](const PyCage& cage) {
                 std::vector<int> groups;
                 for (const mesh::FaceId f : cage.topology().faces())
                     groups.push_back(cage.topology().group(f));
                 return py::make_tuple(cage.topology().group_names(), groups);
             })
        .def("has_sectors", [](const PyCage& cage) { return !cage.topology().sectors().empty(); })
        .def("summary", summary)
        .def("refined", refined_cage)
        .def("evaluate", evaluate)
        .def("masks", masks)
        .def("smoothness", smoothness);
}

}  // namespace patchwright::python
