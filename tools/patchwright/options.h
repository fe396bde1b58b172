// Command-line options that several subcommands share, and what the library takes in their place.
#pragma once

#include "checks.h"
#include "command.h"

#include <patchwright/convert/convert.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace patchwright::cli {

/// An option whose value is one of a few words.
/// @param value  an Enum or an optional one; holds the default, whose word is shown in the help
template <class Enum, class Value>
CLI::Option* add_choice(CLI::App& command, const std::string& name, Value& value,
                        const std::vector<std::pair<std::string, Enum>>& words,
                        const std::string& help) {
    std::string standard, all;
    for (const auto& [word, meaning] : words) {
        if (meaning == value) standard = word;
        all += (all.empty() ? "" : ", ") + word;
    }
    const auto set = [name, words, all, &value](const std::string& text) {
        for (const auto& [word, meaning] : words) {
            if (word != text) continue;
            value = meaning;
            return;
        }
        throw CLI::ValidationError(name, "'" + text + "' is none of " + all);
    };
    return command.add_option_function<std::string>(name, set, help)
        ->type_name("WORD")
        ->default_str(standard);
}

/// Options of subcommands that read a CAD file or triangles.
struct InputOptions {
    std::string unit;                       ///< overrides what the file says; empty: as it says
    bool allow_loss = false;                ///< CAD: go on without faces that cannot be transferred
    std::optional<double> read_limit_s;     ///< CAD: processor time; none: by the file's size
    std::optional<double> sharp_angle_deg;  ///< none: as is usual for the kind of file
    occ::FootPoints foot_points = occ::FootPoints::Search;
};

constexpr const char* input_help = "STEP, IGES, BREP, or triangles: STL, OBJ";
/// Each way: about a gigabyte.
constexpr int most_samples = 10'000'000;
constexpr const char* length_help = "0.05mm, 0.002in, or 1e-4rel (of the diagonal)";

void add_input_options(CLI::App& command, InputOptions& options);
void add_foot_point_option(CLI::App& command, InputOptions& options);

/// The same for the library: read by reader_process(), healed, with a surface.
convert::SourceOptions source_options(const InputOptions& options);

/// What a subcommand needs of a model.
struct ReadingOptions {
    bool heal = true;
    bool with_surface = true;
    base::Progress progress;  ///< none: the run's
};

/// Reads CAD files. It starts at the first call, which main() makes before there are threads.
occ::ReaderProcess& reader_process();

/// Reads a CAD file (in a process of its own) or triangles, passes on what reading noticed, fills
/// report.input.
convert::Source read_source(Run& run, const std::string& file, const InputOptions& options,
                            const ReadingOptions& needed = {});

/// Options of subcommands that make cages.
struct CageArguments {
    cage::Method method = cage::Method::Auto;
    std::optional<int> target_faces;
};

void add_cage_options(CLI::App& command, CageArguments& options);

/// Options of subcommands that fit.
struct FitArguments {
    std::string tolerance = "1e-4rel";
    std::string cage_unit = "mm";
    fit::RefinementScope refinement = fit::RefinementScope::Local;
    fit::Symmetry symmetry = fit::Symmetry::Detect;
    std::optional<mesh::CreaseRule> crease_rule;
    std::optional<int> max_levels;
    std::optional<double> time_limit_s;
};

/// @param refines  whether the cage may be refined, and how
void add_fit_options(CLI::App& command, FitArguments& options, bool refines = true);

/// What conversions and fits of these options do; the shape and the samples stay as they are.
/// @param cage_file  empty: cages are made from the model
convert::ConvertOptions convert_options(Run& run, const convert::Source& source,
                                        const FitArguments& fit, const CageArguments& cage,
                                        const std::string& cage_file);

/// @throw InputError where the source is a control mesh and not a model to be approximated by one
void refuse_control_mesh(const convert::Source& source);

/// Adds --normal-tolerance.
CLI::Option* add_normal_tolerance_option(CLI::App& command, std::string& normal_tolerance);

/// Radians; nothing where the option was not given.
std::optional<double> normal_tolerance_rad(const std::string& normal_tolerance);

/// In millimetres, of this diagonal.
/// @throw UsageError when the text is no length
double length_mm(const std::string& text, double diagonal_mm);

/// Says so where the tolerance is less than the triangles' own distance from what they stand for.
void note_chord_error(Run& run, const convert::Source& source, double tolerance_mm);

/// Before a cage is made of it.
void leave_out_narrow_holes(Run& run, convert::Source& source, double tolerance_mm);

/// Options of subcommands that write a CAD file.
struct OutputOptions {
    std::string file;
    std::string unit = "input";
    convert::ShapeOptions shape;
};

void add_output_options(CLI::App& command, OutputOptions& options);

/// The unit of the file to be written.
/// @param input  unit of the input
base::LengthUnit output_unit(const OutputOptions& options, base::LengthUnit input);

}  // namespace patchwright::cli
