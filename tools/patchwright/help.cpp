#include "help.h"

#include "files.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace patchwright::cli {

namespace {

struct Described {
    std::string group;
    std::string value;  ///< name of the value; words with | between them are all that there are
};

constexpr const char* units = "mm|cm|m|in|ft";
constexpr const char* config_hint =
    "Options may stand in a file as well, below [{}]: --config FILE.toml.";

const std::map<std::string, Described> descriptions{
    {"input", {"", "FILE"}},
    {"file", {"", "FILE"}},
    {"a", {"", "A"}},
    {"b", {"", "B"}},
    {"cage", {"", "CAGE.obj"}},
    {"designs", {"", "FILE"}},
    {"--output", {"Files", "FILE"}},
    {"--cage", {"Files", "CAGE.obj"}},
    {"--cad-out", {"Files", "FILE"}},
    {"--from", {"Files", "FILE"}},
    {"--displacements", {"Files", "FILE.csv"}},
    {"family --output", {"Files", "'FOLDER/{name}.obj'"}},
    {"--modes", {"Accuracy", "N"}},
    {"--modes-out", {"Files", "FILE.csv"}},
    {"member --modes", {"Files", "FILE.csv"}},
    {"--weights", {"Control mesh", "W1,W2"}},
    {"--grid-out", {"Files", "FILE"}},
    {"--velocities-out", {"Files", "FILE.csv"}},
    {"--forces", {"Files", "FILE.csv"}},
    {"--forces-out", {"Files", "FILE.csv"}},
    {"--cage-out", {"Files", "FITTED.obj"}},
    {"--json", {"Files", "FILE.json"}},
    {"--report", {"Files", "FILE.html"}},
    {"--field", {"Files", "FILE.vtp|.glb"}},
    {"--picture", {"Files", "FILE.png"}},
    {"--picture-view", {"Picture", "iso|front|back|left|right|top|bottom"}},
    {"--picture-direction", {"Picture", "X,Y,Z"}},
    {"--picture-zoom", {"Picture", "X,Y,Z,WIDTH"}},
    {"--picture-layer", {"Picture", "deviation|angle|curvature|patches|zebra|plain"}},
    {"--picture-size", {"Picture", "WxH"}},
    {"--input-unit", {"Reading", units}},
    {"--cage-unit", {"Reading", units}},
    {"--allow-loss", {"Reading", ""}},
    {"--read-limit", {"Reading", "SECONDS"}},
    {"--sharp-angle", {"Reading", "DEGREES"}},
    {"--foot-points", {"Accuracy", "search|kernel"}},
    {"--no-heal", {"Reading", ""}},
    {"--tolerance", {"Accuracy", "LENGTH"}},
    {"--normal-tolerance", {"Accuracy", "ANGLE"}},
    {"--samples", {"Accuracy", "N"}},
    {"--time-limit", {"Accuracy", "SECONDS"}},
    {"--layout", {"Control mesh", "aligned|remesh|auto"}},
    {"--target-faces", {"Control mesh", "N"}},
    {"--interpolate", {"Control mesh", ""}},
    {"--max-levels", {"Control mesh", "N"}},
    {"--refine", {"Control mesh", "local|global"}},
    {"--symmetry", {"Control mesh", "detect|x|y|z|none"}},
    {"--crease-rule", {"Control mesh", "catmull-clark|runout"}},
    {"-n", {"Control mesh", "LEVELS"}},
    {"--scheme", {"Control mesh", "edge-split|corner-cutting|de-rham"}},
    {"--at", {"Places", "FACE,U,V"}},
    {"--at-file", {"Places", "FILE.csv"}},
    {"--gradient", {"Files", "FILE.csv"}},
    {"--adjoint", {"Files", "FILE.csv"}},
    {"--jacobian", {"Files", "FILE.mtx"}},
    {"--unit", {"Output", "mm|cm|m|in|ft|input"}},
    {"grid --unit", {"Output", units}},
    {"--schema", {"Output", "ap203|ap214|ap242"}},
    {"--continuity", {"Output", "g1|refined"}},
    {"--patches", {"Output", "charts|faces"}},
    {"--color", {"Output", "none|kind|deviation"}},
    {"--time-stamp", {"Output", ""}},
    {"--cap-depth", {"Output", "N"}},
    {"--plot3d", {"Output", "binary|fortran|ascii"}},
    {"--endian", {"Output", "little|big"}},
    {"--blocks", {"Blocks and spacing", "groups|charts|faces"}},
    {"--no-join", {"Blocks and spacing", ""}},
    {"--size", {"Blocks and spacing", "LENGTH"}},
    {"--points", {"Blocks and spacing", "N"}},
    {"--levels", {"Blocks and spacing", "N"}},
    {"--coarsen", {"Blocks and spacing", "N"}},
    {"--spacing", {"Blocks and spacing", "uniform|geometric|tanh|cosine"}},
    {"--curvature", {"Blocks and spacing", ""}},
    {"--first-cell", {"Blocks and spacing", "LENGTH"}},
    {"--cluster", {"Blocks and spacing", "FAMILY:FAMILY=LENGTH"}},
    {"--smooth", {"Blocks and spacing", ""}},
    {"--size-field", {"Refinement", "FILE.csv|.vtu"}},
    {"--size-array", {"Refinement", "NAME"}},
    {"--sensor", {"Refinement", "FILE.csv|.vtu"}},
    {"--sensor-array", {"Refinement", "NAME"}},
    {"--sensor-jump", {"Refinement", "SHARE"}},
    {"--smallest", {"Refinement", "LENGTH"}},
    {"--hanging-nodes", {"Refinement", "polygons|quads"}},
    {"--rules", {"Blocks and spacing", "FILE.json"}},
    {"--layers", {"Layers", "N"}},
    {"--layer-height", {"Layers", "LENGTH"}},
    {"--thickness", {"Layers", "LENGTH"}},
    {"--farfield", {"Layers", "RADIUS"}},
    {"--growth", {"Layers", "FACTOR"}},
    {"--quiet", {"Run", ""}},
    {"--verbose", {"Run", ""}},
    {"--progress", {"Run", ""}},
    {"--threads", {"Run", "N"}},
    {"--help", {"Run", ""}}};

const std::map<std::string, std::string> examples{
    {"convert",
     "  patchwright convert wing.igs -o wing.step\n"
     "  patchwright convert wing.igs -o wing.step --tolerance 0.1mm --cage-out wing.obj "
     "--report wing.html"},
    {"compare",
     "  patchwright compare old.igs new.step --tolerance 0.05mm --report new.html\n"
     "  patchwright compare old.igs new.step --field deviation.vtp"},
    {"inspect", "  patchwright inspect wing.igs --json -"},
    {"cage", "  patchwright cage wing.step -o cage.obj --target-faces 200"},
    {"fit",
     "  patchwright fit wing.step --cage cage.obj -o fitted.obj --tolerance 0.1mm\n"
     "  patchwright fit wing.step --cage fitted.obj -o through_points.obj --interpolate"},
    {"refit",
     "  patchwright refit fitted.obj bent_wing.step -o bent.obj\n"
     "  patchwright refit fitted.obj bent_wing.step --from wing.step -o bent.obj --cad-out "
     "bent.step"},
    {"family",
     "  patchwright family fitted.obj designs/*.step -o 'members/{name}.obj' --modes 5 "
     "--modes-out modes.csv"},
    {"member",
     "  patchwright member fitted.obj --modes modes.csv --weights 12.5,-3 -o new.obj "
     "--cad-out new.step"},
    {"morph",
     "  patchwright morph fitted.obj --displacements nodes.csv -o bent.obj --cad-out bent.step\n"
     "  patchwright morph fitted.obj --displacements nodes.csv -o bent.obj --forces pressure.csv "
     "--forces-out loads.csv\n"
     "  patchwright morph fitted.obj --displacements t0.csv t1.csv -o {step}.obj --grid-out "
     "{step}.cgns"},
    {"export", "  patchwright export fitted.obj -o wing.step --unit m"},
    {"grid",
     "  patchwright grid fitted.obj -o wing.cgns --size 5mm --spacing tanh --first-cell 0.1mm\n"
     "  patchwright grid fitted.obj -o layers.cgns --layers 30 --layer-height 0.5mm"},
    {"eval",
     "  patchwright eval cage.obj --at 0,0.5,0.5\n"
     "  patchwright eval cage.obj --at-file places.csv -o points.csv --jacobian points.mtx\n"
     "  patchwright eval cage.obj --at-file places.csv --gradient by_points.csv "
     "--adjoint by_cage.csv"},
    {"subdivide",
     "  patchwright subdivide cage.obj -n 2 -o fine.obj --picture fine.png\n"
     "  patchwright subdivide curve.obj -n 6 -o smooth.obj --scheme de-rham"}};

/// Insertions, deletions and replacements of letters from one word to the other (Levenshtein).
std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t(0));
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
        }
    }
    return row.back();
}

/// " (did you mean X?)", or nothing where no word is near.
std::string advice(const std::string& wrong, const std::vector<std::string>& words) {
    const std::string* nearest = nullptr;
    std::size_t least = wrong.size() / 3 + 1;
    for (const std::string& word : words) {
        const std::size_t distance = edit_distance(wrong, word);
        if (distance >= least) continue;
        least = distance;
        nearest = &word;
    }
    return nearest != nullptr ? fmt::format(" (did you mean {}?)", *nearest) : std::string();
}

std::vector<std::string> subcommand_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
    return names;
}

[[noreturn]] void refuse_subcommand(const CLI::App& app, const std::string& name) {
    throw base::UsageError(fmt::format("there is no subcommand '{}'{}; see --help", name,
                                       advice(name, subcommand_names(app))));
}

/// Without the limits that follow it.
std::string value_name(const CLI::Option& option) {
    return option.get_type_name().substr(0, option.get_type_name().find(':'));
}

/// Why there is no such option.
std::string unknown_option(const CLI::App& command, const std::string& name) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options())
        for (const std::string& known : option->get_lnames()) names.push_back("--" + known);
    return fmt::format("{} has no option {}{}; see --help", command.get_name(), name,
                       advice(name, names));
}

void check_option(const CLI::App& app, const CLI::App& command, const std::string& argument) {
    const std::string name = argument.substr(0, argument.find('='));
    if (command.get_option_no_throw(name) == nullptr && app.get_option_no_throw(name) == nullptr)
        throw base::UsageError(unknown_option(command, name));
}

}  // namespace

void describe_commands(CLI::App& app) {
    for (CLI::App* command : app.get_subcommands({})) {
        command->set_help_flag("-h,--help", "print this help");  // anew: the last one
        for (CLI::Option* option : command->get_options()) {
            const std::string name = option->get_positional() ? option->get_name(true)
                                     : option->get_lnames().empty()
                                         ? option->get_name()
                                         : "--" + option->get_lnames().front();
            auto known = descriptions.find(command->get_name() + " " + name);
            if (known == descriptions.end()) known = descriptions.find(name);
            if (known == descriptions.end()) continue;
            if (!option->get_positional()) option->group(known->second.group);
            if (option->get_items_expected_max() > 0) option->type_name(known->second.value);
        }
        const auto shown = examples.find(command->get_name());
        if (shown != examples.end())
            command->footer("Examples:\n" + shown->second + "\n\n" +
                            fmt::format(fmt::runtime(config_hint), command->get_name()));
    }
}

void register_help(CLI::App& app) {
    auto name = std::make_shared<std::string>();
    CLI::App* help = app.add_subcommand("help", "help on a subcommand");
    help->add_option("command", *name, "subcommand; all of them when left out")
        ->type_name("COMMAND");
    help->callback([&app, name] {
        const auto names = subcommand_names(app);
        if (!name->empty() && std::find(names.begin(), names.end(), *name) == names.end())
            refuse_subcommand(app, *name);
        // App::help() would be that of `help` itself.
        const std::string all =
            app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal);
        write_standard_output(name->empty() ? all
                                            : app.get_subcommand(*name)->help(app.get_name()));
    });
    auto shell = std::make_shared<std::string>();
    CLI::App* complete = app.add_subcommand("completion", "completion script for a shell");
    complete->add_option("shell", *shell, "the shell")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh", "fish"}).description(""))
        ->type_name("bash|zsh|fish");
    complete->footer("Examples:\n  source <(patchwright completion bash)");
    complete->callback([&app, shell] { write_standard_output(completion(app, *shell)); });
    CLI::App* man = app.add_subcommand("man", "the manual page's source");
    man->footer("Examples:\n  patchwright man | man -l -");
    man->callback([&app] { write_standard_output(manual(app)); });
}

void check_names(const CLI::App& app, const std::vector<std::string>& arguments) {
    const std::vector<std::string> names = subcommand_names(app);
    const CLI::App* command = nullptr;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const std::string& argument = arguments[i];
        if (argument == "--") return;
        if (command != nullptr) {
            if (argument.starts_with("--")) check_option(app, *command, argument);
            continue;
        }
        if (argument.starts_with("-")) {
            if (argument == "--config") ++i;  // its value
            continue;
        }
        if (std::find(names.begin(), names.end(), argument) == names.end())
            refuse_subcommand(app, argument);
        command = app.get_subcommand(argument);
    }
}

void refuse_config(const CLI::App& app, const std::string& text) {
    const std::string begin = "INI was not able to parse ";  // as CLI11 has it
    if (!text.starts_with(begin)) throw base::UsageError("--config: " + text + "; see --help");
    const std::string item = text.substr(begin.size());
    const std::size_t dot = item.find('.');
    if (dot == std::string::npos) {
        const std::vector<CLI::App*> run = app.get_subcommands();
        throw base::UsageError(fmt::format(
            "--config: {}: options stand below a line with their subcommand: [{}]; see --help",
            item, run.empty() ? "convert" : run.front()->get_name()));
    }
    const std::string section = item.substr(0, dot);
    const std::vector<std::string> names = subcommand_names(app);
    if (std::find(names.begin(), names.end(), section) == names.end())
        refuse_subcommand(app, section);
    throw base::UsageError(
        fmt::format("--config: {}: {}", item,
                    unknown_option(*app.get_subcommand(section), "--" + item.substr(dot + 1))));
}

std::vector<std::string> choices(const CLI::Option& option) {
    const std::string value = value_name(option);
    std::vector<std::string> words;
    if (value.find('|') == std::string::npos || value.find('.') != std::string::npos) return words;
    for (std::size_t begin = 0; begin <= value.size();) {
        const std::size_t end = std::min(value.find('|', begin), value.size());
        words.push_back(value.substr(begin, end - begin));
        begin = end + 1;
    }
    return words;
}

bool takes_file(const CLI::Option& option) {
    const std::string value = value_name(option);
    return option.get_items_expected_max() > 0 &&
           (value == "FILE" || value.find('.') != std::string::npos);
}

}  // namespace patchwright::cli
