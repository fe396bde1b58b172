#include "view.h"

#include "options.h"

#include <patchwright/report/field_file.h>

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

namespace patchwright::cli {

namespace {

/// From the model to the eye; z is up, and wings point along y.
const std::map<std::string, geom::Vec3> views{
    {"iso", {-0.55, -0.8, 0.6}}, {"front", {-1, 0, 0}}, {"back", {1, 0, 0}},   {"left", {0, -1, 0}},
    {"right", {0, 1, 0}},        {"top", {0, 0, 1}},    {"bottom", {0, 0, -1}}};

/// "960x540"
/// @throw UsageError when it is no size
std::pair<int, int> parse_size(const std::string& text) {
    constexpr int most = 8192;
    int width = 0, height = 0;
    const char* const end = text.data() + text.size();
    const auto [middle, error] = std::from_chars(text.data(), end, width);
    if (error == std::errc{} && middle != end && *middle == 'x') {
        const auto [rest, wrong] = std::from_chars(middle + 1, end, height);
        if (wrong == std::errc{} && rest == end && width > 0 && height > 0 && width <= most &&
            height <= most)
            return {width, height};
    }
    throw base::UsageError(
        fmt::format("'{}' is no size; use WIDTHxHEIGHT in pixels, up to {}", text, most));
}

/// "X,Y,Z" and the like.
/// @throw UsageError when these are not so many numbers
std::vector<double> parse_numbers(const std::string& text, std::size_t count, const char* form) {
    std::vector<double> numbers;
    const char* at = text.data();
    const char* const end = text.data() + text.size();
    while (numbers.size() < count) {
        double number = 0.0;
        const auto [after, error] = std::from_chars(at, end, number);
        if (error != std::errc{} || !(std::abs(number) <= geom::largest_coordinate)) break;
        numbers.push_back(number);
        at = after;
        if (at == end || *at != ',') break;
        ++at;
    }
    if (numbers.size() != count || at != end)
        throw base::UsageError(fmt::format("'{}' is not {}", text, form));
    return numbers;
}

/// From the model to the eye.
geom::Vec3 parse_direction(const std::string& text) {
    const auto n = parse_numbers(text, 3, "X,Y,Z from the model to the eye");
    const geom::Vec3 direction(n[0], n[1], n[2]);
    if (!(direction.norm() > 0.0))
        throw base::UsageError(fmt::format("'{}' is no direction", text));
    return direction;
}

report::PictureFrame parse_zoom(const std::string& text, base::LengthUnit unit) {
    const auto n = parse_numbers(text, 4, "X,Y,Z,WIDTH of what is seen");
    if (!(n[3] > 0.0))
        throw base::UsageError(fmt::format("'{}': the width must be positive", text));
    const double scale = base::millimetres_per(unit);
    return {scale * geom::Vec3(n[0], n[1], n[2]), scale * n[3]};
}

/// What the parser has against a text; empty: nothing.
template <class Parse>
auto parses(Parse parse) {
    return [parse](const std::string& text) {
        try {
            parse(text);
        } catch (const base::UsageError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
}

report::PictureOptions picture_options(const ViewArguments& options, base::LengthUnit unit) {
    const auto [width, height] = parse_size(options.size);
    report::PictureOptions picture{.width = width,
                                   .height = height,
                                   .layer = options.layer,
                                   .towards_eye = options.direction.empty()
                                                      ? views.at(options.from)
                                                      : parse_direction(options.direction)};
    if (!options.zoom.empty()) picture.frame = parse_zoom(options.zoom, unit);
    return picture;
}

double largest(const std::vector<double>& values) {
    return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

}  // namespace

void add_view_options(CLI::App& command, ViewArguments& options, bool with_field) {
    if (with_field)
        command.add_option("--field", options.field,
                           "write deviation, normal angle and curvature all over the output: .vtp "
                           "(ParaView) or .glb");
    add_picture_options(command, options);
}

void add_picture_options(CLI::App& command, ViewArguments& options) {
    using report::PictureLayer;
    command.add_option("--picture", options.picture, "draw the output: .png");
    CLI::Option* const from =
        command.add_option("--picture-view", options.from, "where it is seen from")
            ->check(CLI::IsMember(&views).description(""))
            ->capture_default_str();
    command
        .add_option("--picture-direction", options.direction,
                    "where it is seen from, as a direction from the model to the eye")
        ->check(parses(parse_direction))
        ->excludes(from);
    command
        .add_option("--picture-zoom", options.zoom,
                    "middle and width of what is seen, in the output's unit; without, all is")
        ->check(parses(
            [](const std::string& text) { parse_zoom(text, base::LengthUnit::Millimetre); }));
    add_choice<PictureLayer>(command, "--picture-layer", options.layer,
                             {{"deviation", PictureLayer::Deviation},
                              {"angle", PictureLayer::NormalAngle},
                              {"curvature", PictureLayer::Curvature},
                              {"patches", PictureLayer::Patches},
                              {"zebra", PictureLayer::Zebra},
                              {"plain", PictureLayer::Plain}},
                             "what its colours are");
    command.add_option("--picture-size", options.size, "pixels")
        ->check(parses(parse_size))
        ->capture_default_str();
}

std::vector<OutputFile> view_files(const ViewArguments& options) {
    return {{"--field", options.field, OutputKind::Field},
            {"--picture", options.picture, OutputKind::Picture}};
}

bool shows_anything(const Run& run, const ViewArguments& options) {
    return !options.field.empty() || !options.picture.empty() || run.writes_page();
}

void add_views(Run& run, const ViewArguments& options, const View& view) {
    if (!shows_anything(run, options)) return;
    const measure::FieldOptions measuring{.progress = run.progress()};
    measure::Field output = measure::measure_field(*view.output, view.input, measuring);
    const double farthest = largest(output.distance_mm);
    const double scale = view.scale_mm.value_or(farthest > 0.0 ? farthest : 1.0);
    if (!options.field.empty())
        run.outputs.add(options.field, has_extension(options.field, ".vtp")
                                           ? report::to_vtp(output, run.report.unit)
                                           : report::to_glb(output, scale));
    if (!options.picture.empty()) {
        report::PictureOptions picture = picture_options(options, run.report.unit);
        picture.scale_mm = scale;
        run.outputs.add(options.picture, report::to_png(output, picture));
    }
    if (run.writes_page()) {
        report::Scene scene{.output = std::move(output), .scale_mm = scale};
        if (view.input != nullptr)
            scene.input = measure::measure_field(*view.input, view.output, measuring);
        if (view.cage != nullptr) scene.cage = *view.cage;
        run.report.scene = std::move(scene);
    }
    run.end_stage("view");
}

void add_drawing(Run& run, const ViewArguments& options, const report::MeshDrawing& drawing,
                 const std::string& caption) {
    report::PictureOptions picture = picture_options(options, run.report.unit);
    if (!options.picture.empty())
        run.outputs.add(options.picture, report::to_png(drawing.field, picture, drawing.edges));
    if (run.writes_page()) {
        picture.is_transparent = true;
        run.report.drawing = {report::to_png(drawing.field, picture, drawing.edges), caption};
    }
    run.end_stage("view");
}

}  // namespace patchwright::cli
