#include "report/colour_scale.h"

#include <patchwright/base/error.h>
#include <patchwright/report/field_file.h>

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <sstream>
#include <utility>
#include <vector>

namespace patchwright::report {

namespace {

std::vector<float> scaled(const std::vector<double>& values, double factor) {
    std::vector<float> result(values.size());
    std::transform(values.begin(), values.end(), result.begin(),
                   [&](double value) { return float(value * factor); });
    return result;
}

struct NamedValues {
    std::string name;
    std::vector<float> values;
};

/// @param per_mm  units a millimetre
std::vector<NamedValues> point_values(const measure::Field& field,
                                      const std::array<const char*, 4>& names, double per_mm) {
    std::vector<NamedValues> all{{names[0], scaled(field.curvature, 1.0 / per_mm)}};
    if (field.distance_mm.empty()) return all;
    all.push_back({names[1], scaled(field.distance_mm, per_mm)});
    all.push_back({names[2], scaled(field.normal_angle_rad, 180.0 / M_PI)});
    all.push_back({names[3], scaled(field.other_curvature, 1.0 / per_mm)});
    return all;
}

/// Data arrays of VTK's XML and the raw bytes that they refer to.
/// Source: VTK file formats (Kitware), XML, polygons with raw appended data.
class VtkArrays {
  public:
    template <class T>
    std::string add(const char* type, const std::string& name, int components,
                    const std::vector<T>& values) {
        std::string text = fmt::format(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
            "offset=\"{}\"/>\n",
            type, name, components, bytes_.size());
        const std::uint64_t size = sizeof(T) * values.size();
        append(&size, sizeof size);
        append(values.data(), size);
        return text;
    }
    [[nodiscard]] const std::string& bytes() const { return bytes_; }

  private:
    void append(const void* data, std::size_t size) {
        bytes_.append(static_cast<const char*>(data), size);
    }
    std::string bytes_;
};

/// All vertices of the field, then those of its lines.
std::vector<double> all_points(const measure::Field& field, double per_mm) {
    std::vector<double> values;
    const auto add = [&](const geom::Points& points) {
        for (Eigen::Index i = 0; i < points.size(); ++i)
            values.push_back(points.data()[i] * per_mm);
    };
    add(field.points);
    for (const geom::Points& line : field.lines) add(line);
    return values;
}

struct Cells {
    std::vector<std::int64_t> vertices, ends;
};

std::string text_of(VtkArrays& arrays, const char* element, const Cells& cells) {
    return fmt::format("<{0}>\n{1}{2}</{0}>\n", element,
                       arrays.add("Int64", "connectivity", 1, cells.vertices),
                       arrays.add("Int64", "offsets", 1, cells.ends));
}

Cells lines_of(const measure::Field& field) {
    Cells lines;
    std::int64_t next = field.points.rows();
    for (const geom::Points& line : field.lines) {
        for (Eigen::Index i = 0; i < line.rows(); ++i) lines.vertices.push_back(next++);
        lines.ends.push_back(std::int64_t(lines.vertices.size()));
    }
    return lines;
}

Cells triangles_of(const measure::Field& field) {
    Cells cells;
    for (const std::array<int, 3>& t : field.triangles) {
        cells.vertices.insert(cells.vertices.end(), t.begin(), t.end());
        cells.ends.push_back(std::int64_t(cells.vertices.size()));
    }
    return cells;
}

/// Collects the buffer of a glTF model.
class GltfBuffer {
  public:
    template <class T>
    int add(const std::vector<T>& values, int component_type, int type, int components,
            int target = TINYGLTF_TARGET_ARRAY_BUFFER) {
        tinygltf::BufferView view;
        view.buffer = 0;
        view.byteOffset = bytes_.size();
        view.byteLength = sizeof(T) * values.size();
        view.target = target;
        bytes_.resize(bytes_.size() + view.byteLength);
        std::memcpy(bytes_.data() + view.byteOffset, values.data(), view.byteLength);
        tinygltf::Accessor accessor;
        accessor.bufferView = int(model.bufferViews.size());
        accessor.componentType = component_type;
        accessor.type = type;
        accessor.count = values.size() / std::size_t(components);
        model.bufferViews.push_back(view);
        model.accessors.push_back(accessor);
        return int(model.accessors.size()) - 1;
    }

    /// Metres, with y up as glTF has it, and the box that positions need.
    int add_points(const geom::Points& points) {
        constexpr double metres = 1e-3;
        std::vector<float> values;
        for (Eigen::Index i = 0; i < points.rows(); ++i)
            for (const double x : {points(i, 0), points(i, 2), -points(i, 1)})
                values.push_back(float(x * metres));
        const int number = add(values, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, 3);
        tinygltf::Accessor& accessor = model.accessors.back();
        accessor.minValues.assign(3, std::numeric_limits<double>::infinity());
        accessor.maxValues.assign(3, -std::numeric_limits<double>::infinity());
        for (std::size_t i = 0; i < values.size(); ++i) {
            accessor.minValues[i % 3] = std::min(accessor.minValues[i % 3], double(values[i]));
            accessor.maxValues[i % 3] = std::max(accessor.maxValues[i % 3], double(values[i]));
        }
        return number;
    }

    int add_floats(const std::vector<float>& values) {
        return add(values, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR, 1);
    }

    /// A mesh of one primitive, and a node that shows it.
    void add_node(const char* name, tinygltf::Primitive primitive) {
        tinygltf::Mesh mesh;
        mesh.name = name;
        mesh.primitives.push_back(std::move(primitive));
        tinygltf::Node node;
        node.name = name;
        node.mesh = int(model.meshes.size());
        model.meshes.push_back(std::move(mesh));
        model.scenes.front().nodes.push_back(int(model.nodes.size()));
        model.nodes.push_back(std::move(node));
    }

    std::string finish() {
        tinygltf::Buffer buffer;
        buffer.data = std::move(bytes_);
        model.buffers.push_back(std::move(buffer));
        std::ostringstream stream;
        if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, stream, false, true))
            throw base::OutputError("the field cannot be written as glTF");
        return stream.str();
    }

    tinygltf::Model model;

  private:
    std::vector<unsigned char> bytes_;
};

/// glTF wants unit normals everywhere.
std::vector<float> gltf_normals(const geom::Points& normals) {
    std::vector<float> values;
    for (Eigen::Index i = 0; i < normals.rows(); ++i) {
        const geom::Vec3 n = normals.row(i).isZero(0.0) ? geom::Vec3::UnitZ()
                                                        : geom::Vec3(normals.row(i).transpose());
        for (const double x : {n.x(), n.z(), -n.y()}) values.push_back(float(x));
    }
    return values;
}

std::vector<unsigned char> colours_of(const measure::Field& field, double scale_mm) {
    std::vector<unsigned char> values;
    for (Eigen::Index i = 0; i < field.points.rows(); ++i) {
        const base::Colour colour =
            field.distance_mm.empty() ? base::Colour{0.7, 0.7, 0.7}
                                      : scale_colour(field.distance_mm[std::size_t(i)] / scale_mm);
        // Vertex colours of glTF are linear, not sRGB.
        for (const double c : {colour.red, colour.green, colour.blue, 1.0})
            values.push_back(static_cast<unsigned char>(std::lround(255.0 * std::pow(c, 2.2))));
    }
    return values;
}

/// All in one mesh of line segments.
void add_lines(GltfBuffer& buffer, const measure::Field& field) {
    const std::vector<double> values = all_points({.lines = field.lines}, 1.0);
    tinygltf::Primitive lines;
    lines.mode = TINYGLTF_MODE_LINE;
    lines.material = 1;
    lines.attributes["POSITION"] = buffer.add_points(
        Eigen::Map<const geom::Points>(values.data(), Eigen::Index(values.size()) / 3, 3));
    std::vector<std::uint32_t> indices;
    std::uint32_t next = 0;
    for (const geom::Points& line : field.lines) {
        for (Eigen::Index i = 0; i + 1 < line.rows(); ++i)
            indices.insert(indices.end(), {next + std::uint32_t(i), next + std::uint32_t(i) + 1});
        next += std::uint32_t(line.rows());
    }
    lines.indices = buffer.add(indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR,
                               1, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    buffer.add_node("feature lines", std::move(lines));
}

tinygltf::Material material(const char* name, std::vector<double> colour) {
    tinygltf::Material result;
    result.name = name;
    result.doubleSided = true;
    result.pbrMetallicRoughness.baseColorFactor = std::move(colour);
    result.pbrMetallicRoughness.metallicFactor = 0.0;
    result.pbrMetallicRoughness.roughnessFactor = 0.6;
    return result;
}

}  // namespace

std::string to_vtp(const measure::Field& field, base::LengthUnit unit) {
    const double per_mm = 1.0 / base::millimetres_per(unit);
    const std::vector<double> points = all_points(field, per_mm);
    const std::size_t count = points.size() / 3;
    const Cells lines = lines_of(field), triangles = triangles_of(field);
    VtkArrays arrays;
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{}\" "
        "header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"{}\" NumberOfLines=\"{}\" "
        "NumberOfPolys=\"{}\">\n<Points>\n{}</Points>\n<PointData Scalars=\"{}\" "
        "Normals=\"Normals\">\n",
        std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", count,
        lines.ends.size(), triangles.ends.size(), arrays.add("Float64", "Points", 3, points),
        field.distance_mm.empty() ? "curvature" : "deviation");
    std::vector<float> normals(field.normals.data(), field.normals.data() + field.normals.size());
    normals.resize(3 * count, 0.0F);
    text += arrays.add("Float32", "Normals", 3, normals);
    for (NamedValues& array : point_values(
             field, {"curvature", "deviation", "normal angle [degrees]", "other curvature"},
             per_mm)) {
        array.values.resize(count, 0.0F);
        text += arrays.add("Float32", array.name, 1, array.values);
    }
    // Cells are numbered lines first.
    std::vector<std::int32_t> faces(lines.ends.size(), -1);
    faces.insert(faces.end(), field.faces.begin(), field.faces.end());
    text += fmt::format("</PointData>\n<CellData>\n{}</CellData>\n",
                        arrays.add("Int32", "face", 1, faces));
    text += text_of(arrays, "Lines", lines);
    text += text_of(arrays, "Polys", triangles);
    text += "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
    return text + arrays.bytes() + "\n</AppendedData>\n</VTKFile>\n";
}

std::string to_glb(const measure::Field& field, double scale_mm) {
    GltfBuffer buffer;
    tinygltf::Model& model = buffer.model;
    model.asset.version = "2.0";
    model.asset.generator = "patchwright";
    model.scenes.emplace_back();
    model.defaultScene = 0;
    model.materials = {material("surface", {1.0, 1.0, 1.0, 1.0}),
                       material("lines", {0.05, 0.05, 0.05, 1.0})};
    tinygltf::Primitive surface;
    surface.mode = TINYGLTF_MODE_TRIANGLES;
    surface.material = 0;
    surface.attributes["POSITION"] = buffer.add_points(field.points);
    surface.attributes["NORMAL"] = buffer.add(gltf_normals(field.normals),
                                              TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, 3);
    surface.attributes["COLOR_0"] = buffer.add(
        colours_of(field, scale_mm), TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_VEC4, 4);
    model.accessors.back().normalized = true;
    for (const NamedValues& array : point_values(
             field, {"_CURVATURE", "_DEVIATION", "_NORMAL_ANGLE", "_OTHER_CURVATURE"}, 1.0))
        surface.attributes[array.name] = buffer.add_floats(array.values);
    std::vector<std::uint32_t> indices;
    for (const std::array<int, 3>& t : field.triangles)
        indices.insert(indices.end(), t.begin(), t.end());
    surface.indices = buffer.add(indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                                 TINYGLTF_TYPE_SCALAR, 1, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    buffer.add_node("output", std::move(surface));
    if (!field.lines.empty()) add_lines(buffer, field);
    return buffer.finish();
}

}  // namespace patchwright::report
