#include "report/page_data.h"

#include "report/colour_scale.h"
#include "report/thin_field.h"

#include <patchwright/subd/limit_mask.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace patchwright::report {

namespace {

using Json = nlohmann::ordered_json;

constexpr int most_of_16_bits = 65535;
/// Of a model; each takes 42 bytes of text.
constexpr int most_vertices = 36000;

template <class T>
Json packed(const std::vector<T>& values) {
    return base64(values.data(), sizeof(T) * values.size());
}

/// From `low` to `high` as 16 bits.
std::uint16_t step_of(double value, double low, double high) {
    const double t = high > low ? std::clamp((value - low) / (high - low), 0.0, 1.0) : 0.0;
    return std::uint16_t(std::lround(t * most_of_16_bits));
}

Json ranged(const std::vector<double>& values, double low, double high) {
    std::vector<std::uint16_t> steps;
    for (const double value : values) steps.push_back(step_of(value, low, high));
    return {{"low", low}, {"high", high}, {"steps", packed(steps)}};
}

double largest(const std::vector<double>& values) {
    return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

Json triple(const geom::Vec3& p) { return {p.x(), p.y(), p.z()}; }

/// Each coordinate as 16 bits of the box.
Json packed_points(const geom::Points& points) {
    if (points.rows() == 0) return {{"low", {0, 0, 0}}, {"high", {0, 0, 0}}, {"steps", ""}};
    const geom::Box3 box = geom::bounding_box(points);
    std::vector<std::uint16_t> steps;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        for (int k = 0; k < 3; ++k) steps.push_back(step_of(points(i, k), box.min[k], box.max[k]));
    return {{"low", triple(box.min)}, {"high", triple(box.max)}, {"steps", packed(steps)}};
}

/// All in one list, and where each ends.
Json packed_lines(const std::vector<geom::Points>& lines) {
    Json ends = Json::array();
    Eigen::Index count = 0;
    for (const geom::Points& line : lines) ends.push_back(count += line.rows());
    geom::Points all(count, 3);
    Eigen::Index next = 0;
    for (const geom::Points& line : lines) {
        all.middleRows(next, line.rows()) = line;
        next += line.rows();
    }
    return {{"points", packed_points(all)}, {"ends", ends}};
}

Json model(const std::string& name, const measure::Field& whole, double curvature) {
    const measure::Field field = thin_field(whole, most_vertices);
    std::vector<std::int16_t> normals;
    for (Eigen::Index i = 0; i < field.normals.size(); ++i)
        normals.push_back(std::int16_t(std::lround(32767.0 * field.normals.data()[i])));
    std::vector<std::uint16_t> indices;
    for (const auto& t : field.triangles)
        for (const int vertex : t) indices.push_back(std::uint16_t(vertex));
    std::vector<std::uint16_t> faces(std::size_t(field.points.rows()), 0);
    for (std::size_t i = 0; i < field.triangles.size(); ++i)
        for (const int vertex : field.triangles[i])
            faces[std::size_t(vertex)] = std::uint16_t(field.faces[i] % (most_of_16_bits + 1));
    Json json{{"name", name},
              {"points", packed_points(field.points)},
              {"normals", packed(normals)},
              {"triangles", packed(indices)},
              {"faces", packed(faces)},
              {"curvature", ranged(field.curvature, -curvature, curvature)},
              {"lines", packed_lines(field.lines)}};
    if (!field.distance_mm.empty()) {
        json["deviation"] = ranged(field.distance_mm, 0.0, largest(whole.distance_mm));
        json["angle"] = ranged(field.normal_angle_rad, 0.0, M_PI / 2.0);
    }
    return json;
}

Json cage_json(const mesh::Cage& cage) {
    const mesh::Topology& topology = *cage.topology;
    std::vector<std::uint16_t> edges;
    for (const mesh::EdgeId e : topology.edges()) {
        edges.push_back(std::uint16_t(topology.start(e).value));
        edges.push_back(std::uint16_t(topology.end(e).value));
    }
    std::vector<geom::Vec3> found;
    const subd::LimitEvaluator limit(cage.topology);
    for (const mesh::VertexId v : topology.vertices())
        if (mesh::is_extraordinary(topology, v)) found.push_back(limit.position(cage.points, v));
    geom::Points extraordinary(Eigen::Index(found.size()), 3);
    for (std::size_t i = 0; i < found.size(); ++i)
        extraordinary.row(Eigen::Index(i)) = found[i].transpose();
    return {{"points", packed_points(cage.points)},
            {"edges", packed(edges)},
            {"extraordinary", packed_points(extraordinary)}};
}

Json plot_json(const Plot& plot) {
    Json series = Json::array();
    for (const Series& s : plot.series) series.push_back({{"name", s.name}, {"values", s.values}});
    Json json{{"caption", plot.caption}, {"xLabel", plot.x_label},
              {"yLabel", plot.y_label},  {"x", plot.x},
              {"series", series},        {"log", plot.is_log},
              {"bars", plot.has_bars}};
    if (plot.limit) json["limit"] = *plot.limit;
    return json;
}

}  // namespace

std::string base64(const void* bytes, std::size_t count) {
    constexpr const char* digits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const auto* from = static_cast<const unsigned char*>(bytes);
    std::string text;
    text.reserve((count + 2) / 3 * 4);
    for (std::size_t i = 0; i < count; i += 3) {
        std::uint32_t three = 0;
        for (std::size_t k = 0; k < 3; ++k) three = three << 8 | (i + k < count ? from[i + k] : 0U);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k > count ? '=' : digits[three >> (18 - 6 * k) & 63U];
    }
    return text;
}

std::vector<Place> places(const RunReport& report) {
    const double scale = 1.0 / base::millimetres_per(report.unit);
    const auto where = [&](const geom::Vec3& p) {
        return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x() * scale, p.y() * scale, p.z() * scale);
    };
    std::vector<Place> all;
    if (report.verdict)
        for (const measure::Condition& c : report.verdict->conditions)
            if (!c.met && c.at)
                all.push_back({*c.at, fmt::format("missed: {} at {}",
                                                  measure::name_of(c.requirement), where(*c.at))});
    if (!report.deviation) return all;
    for (const auto& [name, deviation] :
         {std::pair("output to input", &report.deviation->output_to_input),
          std::pair("input to output", &report.deviation->input_to_output)})
        for (const measure::DeviationPlace& place : deviation->worst)
            all.push_back(
                {place.point,
                 fmt::format("{}: {:.4g} {} at {}, face {}", name, place.distance * scale,
                             base::short_name(report.unit), where(place.point), place.face)});
    return all;
}

std::string page_data(const RunReport& report, const std::vector<Plot>& plots) {
    Json json{{"unit", base::short_name(report.unit)},
              {"mmPerUnit", base::millimetres_per(report.unit)},
              {"plots", Json::array()}};
    for (const Plot& plot : plots) json["plots"].push_back(plot_json(plot));
    if (report.scene) {
        const Scene& scene = *report.scene;
        const double curvature = usual_curvature(
            {scene.output ? &*scene.output : nullptr, scene.input ? &*scene.input : nullptr});
        json["scale"] = scene.scale_mm;
        for (const base::Colour& c : scale_stops)
            json["colours"].push_back({c.red, c.green, c.blue});
        for (const auto& [name, field] :
             {std::pair("input", &scene.input),
              std::pair(scene.input ? "output" : "model", &scene.output)})
            if (*field) json["models"].push_back(model(name, **field, curvature));
        if (scene.cage && scene.cage->points.rows() <= most_of_16_bits)
            json["cage"] = cage_json(*scene.cage);
        for (const Place& place : places(report))
            json["places"].push_back({place.at.x(), place.at.y(), place.at.z()});
    }
    std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    // A script element ends at "</".
    for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;)
        text.replace(at, 1, "\\u003c");
    return text;
}

}  // namespace patchwright::report
