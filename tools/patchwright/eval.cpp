#include "command.h"
#include "eval_files.h"

#include <patchwright/base/error.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/normal_control.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <charconv>
#include <memory>

namespace patchwright::cli {

namespace {

struct EvalOptions {
    CommonOptions common;
    std::string cage;
    std::vector<std::string> at;
    EvalFiles files;
};

/// "FACE,U,V" or "FACE,U,V,SECTOR".
subd::Location parse_location(const std::string& text) {
    std::vector<double> numbers;
    const char* p = text.data();
    const char* const end = p + text.size();
    for (;;) {
        double value = 0.0;
        const auto [next, error] = std::from_chars(p, end, value);
        if (error != std::errc{} || (next != end && *next != ',')) {
            throw base::UsageError(
                fmt::format("'{}' is no place on a cage; use FACE,U,V such as 0,0.5,0.25", text));
        }
        numbers.push_back(value);
        if (next == end) break;
        p = next + 1;
    }
    const auto whole = [](double x) { return x == std::floor(x) && x >= 0 && x < 1e9; };
    if (numbers.size() < 3 || numbers.size() > 4 || !whole(numbers[0]) ||
        (numbers.size() == 4 && !whole(numbers[3]))) {
        throw base::UsageError(fmt::format(
            "'{}' is no place on a cage; use FACE,U,V, with ,SECTOR where the face is no quad",
            text));
    }
    return {mesh::FaceId{static_cast<std::int32_t>(numbers[0])}, numbers[1], numbers[2],
            numbers.size() == 4 ? static_cast<int>(numbers[3]) : 0};
}

const char* name_of(subd::Smoothness smoothness) {
    switch (smoothness) {
        case subd::Smoothness::Derivatives: return "derivatives";
        case subd::Smoothness::TangentPlane: return "tangent plane only";
        case subd::Smoothness::Position: return "position only";
    }
    return "";
}

constexpr const char* row_names[6] = {"position", "du", "dv", "duu", "duv", "dvv"};

nlohmann::ordered_json to_json(const subd::Location& at, const subd::LimitPoint& point,
                               const subd::Mask& mask) {
    nlohmann::ordered_json json = {{"face", at.face.value},
                                   {"u", at.u},
                                   {"v", at.v},
                                   {"sector", at.sector},
                                   {"exists", name_of(mask.smoothness)}};
    const geom::Vec3* const values[6] = {&point.position, &point.du,  &point.dv,
                                         &point.duu,      &point.duv, &point.dvv};
    json["mask"]["vertices"] = mask.vertices;
    const int rows = mask.smoothness == subd::Smoothness::Derivatives    ? 6
                     : mask.smoothness == subd::Smoothness::TangentPlane ? 3
                                                                         : 1;
    for (int row = 0; row < rows; ++row) {
        json[row_names[row]] = {values[row]->x(), values[row]->y(), values[row]->z()};
        const Eigen::VectorXd weights = mask.rows.row(row);
        json["mask"][row_names[row]] = std::vector<double>(weights.begin(), weights.end());
    }
    if (!point.normal.isZero()) {
        json["normal"] = {point.normal.x(), point.normal.y(), point.normal.z()};
    }
    return json;
}

std::string to_text(const nlohmann::ordered_json& json) {
    std::string text = fmt::format("face {} at ({}, {}), sector {}: {}\n", json["face"].get<int>(),
                                   json["u"].get<double>(), json["v"].get<double>(),
                                   json["sector"].get<int>(), json["exists"].get<std::string>());
    for (const char* key : {"position", "du", "dv", "normal", "duu", "duv", "dvv"}) {
        if (!json.contains(key)) continue;
        const auto& p = json[key];
        text += fmt::format("  {:<9} {:.15g} {:.15g} {:.15g}\n", key, p[0].get<double>(),
                            p[1].get<double>(), p[2].get<double>());
    }
    text += "  mask     ";
    const auto& mask = json["mask"];
    for (std::size_t k = 0; k < mask["vertices"].size(); ++k) {
        text += fmt::format(" {}:{:.12g}", mask["vertices"][k].get<int>(),
                            mask["position"][k].get<double>());
    }
    return text + "\n";
}

void check_options(const EvalOptions& options) {
    if (options.at.empty() && options.files.at_file.empty())
        throw base::UsageError("no places; use --at or --at-file");
    if (options.at.empty() && options.files.output.empty() && options.files.jacobian.empty() &&
        options.files.adjoint.empty())
        throw base::UsageError("nothing to write; use --output, --jacobian or --adjoint");
    if (options.files.gradient.empty() != options.files.adjoint.empty())
        throw base::UsageError("--gradient and --adjoint go together");
}

int eval(const EvalOptions& options) {
    check_options(options);
    Places places;
    for (const std::string& text : options.at) places.add(parse_location(text));
    Run run(options.common, {{options.cage, options.files.at_file, options.files.gradient},
                             {{"--output", options.files.output, OutputKind::Table},
                              {"--jacobian", options.files.jacobian, OutputKind::Matrix},
                              {"--adjoint", options.files.adjoint, OutputKind::Table}}});
    const mesh::Cage given = about_input(
        options.cage, [&] { return read_cage(run, options.cage, base::LengthUnit::Millimetre); });
    const mesh::Cage cage = about_input(options.cage, [&] { return subd::control_normals(given); });
    if (!(options.files.jacobian + options.files.adjoint).empty())
        refuse_sectors(options.cage, *given.topology, "--jacobian and --adjoint");
    const subd::LimitEvaluator evaluator(cage.topology);
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    std::string text;
    for (std::size_t i = 0; i < options.at.size(); ++i) {
        const subd::Location at = places.locations()[i];
        all.push_back(to_json(at, evaluator.evaluate(cage.points, at), evaluator.mask(at, 2)));
        text += to_text(all.back());
    }
    if (!options.files.at_file.empty()) places.read(options.files.at_file, *cage.topology);
    run.end_stage("read");
    text += write_eval_files(run, cage, evaluator, places, options.files);
    return run.finish(all.dump(2) + "\n", "", text);
}

}  // namespace

void register_eval(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<EvalOptions>();
    CLI::App* command = app.add_subcommand(
        "eval", "limit point, derivatives, normal and masks at places of a cage");
    command->add_option("cage", options->cage, "control mesh (OBJ)")->required();
    command->add_option("--at", options->at,
                        "FACE,U,V: faces count from 0, (0,0) is the face's first vertex, u runs to "
                        "the second; FACE,U,V,SECTOR for faces that are no quads");
    command->add_option("--at-file", options->files.at_file,
                        "places, one a line as of --at; after those of --at");
    command->add_option("-o,--output", options->files.output,
                        "points and unit normals of all places (CSV); 0,0,0 where no normal is");
    command->add_option("--jacobian", options->files.jacobian,
                        "derivatives of points by control points (MatrixMarket): a row a place, a "
                        "column a vertex, the same for x, y and z");
    command->add_option("--gradient", options->files.gradient,
                        "derivatives of a quantity by the points: x,y,z of each place a line");
    command->add_option("--adjoint", options->files.adjoint,
                        "the quantity's derivatives by the control points (CSV)");
    add_common_options(*command, options->common, false);
    command->callback([options, &exit_code] { exit_code = eval(*options); });
}

}  // namespace patchwright::cli
