#include <patchwright/base/error.h>
#include <patchwright/grid/rules.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <limits>

namespace patchwright::grid {

namespace {

using nlohmann::json;

// Enough points to tell edges of one cage from each other.
constexpr int points_an_edge = 32;

/// The edge that comes nearest to a point; whether the point is nearer to its last end.
struct Picked {
    int edge = -1;
    bool from_last = false;
};

Picked pick(const Plan& plan, const geom::Vec3& at) {
    Picked picked;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t e = 0; e < plan.edges.size(); ++e) {
        const geom::Points& points = plan.edges[e].points;
        const double distance = (points.rowwise() - at.transpose()).rowwise().norm().minCoeff();
        if (distance >= nearest) continue;
        nearest = distance;
        picked = {int(e), (points.row(points.rows() - 1) - at.transpose()).norm() <
                              (points.row(0) - at.transpose()).norm()};
    }
    return picked;
}

EdgeRule read_rule(const json& rule, const Plan& plan, double scale, double diagonal) {
    if (!rule.is_object()) throw base::UsageError("is no object");
    for (const auto& [key, value] : rule.items()) {
        if (key != "at" && key != "only" && key != "cells" && key != "spacing" && key != "near" &&
            key != "far") {
            throw base::UsageError(fmt::format(
                "has an unknown key '{}'; use at, only, cells, spacing, near, far", key));
        }
    }
    const auto at = rule.find("at");
    if (at == rule.end() || !at->is_array() || at->size() != 3) {
        throw base::UsageError("has no \"at\": [x, y, z]");
    }
    const auto length = [&](const char* key) -> std::optional<double> {
        if (!rule.contains(key)) return std::nullopt;
        return base::parse_length(rule.at(key).get<std::string>()).in_millimetres(diagonal);
    };
    const geom::Vec3 point = scale * geom::Vec3(at->at(0).get<double>(), at->at(1).get<double>(),
                                                at->at(2).get<double>());
    if (!(point.cwiseAbs().maxCoeff() <= geom::largest_coordinate))
        throw base::UsageError(
            fmt::format("has a coordinate above {:g}", geom::largest_coordinate));
    const Picked picked = pick(plan, point);
    EdgeRule result{.edge = picked.edge, .connected = !rule.value("only", false)};
    if (rule.contains("cells")) result.cells = rule.at("cells").get<int>();
    if (rule.contains("spacing")) {
        const auto name = rule.at("spacing").get<std::string>();
        const auto law = spacing_laws().find(name);
        if (law == spacing_laws().end()) {
            throw base::UsageError(
                fmt::format("has spacing '{}'; use uniform, geometric, tanh or cosine", name));
        }
        result.law = law->second;
    }
    result.first_mm = length(picked.from_last ? "far" : "near");
    result.last_mm = length(picked.from_last ? "near" : "far");
    return result;
}

}  // namespace

const std::map<std::string, Law>& spacing_laws() {
    static const std::map<std::string, Law> laws{{"uniform", Law::Uniform},
                                                 {"geometric", Law::Geometric},
                                                 {"tanh", Law::Tanh},
                                                 {"cosine", Law::Cosine}};
    return laws;
}

std::vector<EdgeRule> parse_rules(std::string_view text, const BlockLayout& layout,
                                  base::LengthUnit unit, double diagonal_mm) {
    std::vector<EdgeRule> rules;
    try {
        const json content = json::parse(text);
        if (!content.is_array()) throw base::InputError("no array of rules");
        const Plan plan = make_plan(layout, {.cells = points_an_edge});
        for (const json& rule : content) {
            try {
                rules.push_back(read_rule(rule, plan, base::millimetres_per(unit), diagonal_mm));
            } catch (const json::exception& error) {
                throw base::InputError(fmt::format("rule {}: {}", rules.size() + 1, error.what()));
            } catch (const base::UsageError& error) {
                throw base::InputError(fmt::format("rule {} {}", rules.size() + 1, error.what()));
            }
        }
    } catch (const json::exception& error) {
        throw base::InputError(fmt::format("no JSON: {}", error.what()));
    }
    return rules;
}

}  // namespace patchwright::grid
