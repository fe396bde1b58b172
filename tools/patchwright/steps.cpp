#include "steps.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace patchwright::cli {

namespace {

/// @throw UsageError where steps would write the same file
void check_pattern(const char* option, const std::string& pattern, std::size_t steps) {
    if (steps < 2 || pattern.empty() || pattern.find(step_placeholder) != std::string::npos) return;
    throw base::UsageError(fmt::format(
        "{}: {} writes a file for each of {} files of displacements; put {} into its name, where "
        "theirs shall stand",
        pattern, option, steps, step_placeholder));
}

/// A structural model's points, displacements and, where there are nine columns, velocities.
Table read_displacements(const StepFiles& step) {
    Table table = read_table(step.displacements, 6, 9);
    if (table.columns != 6 && table.columns != 9)
        throw base::InputError(
            fmt::format("{}has {} numbers; 6 or 9 are expected: x, y, z, dx, dy, "
                        "dz, and perhaps vx, vy, vz",
                        table.place(0), table.columns));
    if (table.columns == 6 && !step.outputs.velocities.empty())
        throw base::InputError(
            fmt::format("{}has no velocities for --velocities-out; add vx, vy, "
                        "vz as the columns 7 to 9",
                        table.place(0)));
    for (std::size_t i = 0; i < table.rows(); ++i)
        for (std::size_t k = 0; k < table.columns; ++k)
            if (!(std::abs(table.row(i)[k]) <= geom::largest_coordinate))
                throw base::InputError(fmt::format("{}'{}' is above {:g}", table.place(i),
                                                   table.row(i)[k], geom::largest_coordinate));
    return table;
}

/// @throw InputError naming the line where the steps' points differ
void check_same_points(const Table& first, const Table& table) {
    if (table.columns != first.columns)
        throw base::InputError(fmt::format("{}has {} numbers; {} are expected, as in {}",
                                           table.place(0), table.columns, first.columns,
                                           first.file));
    for (std::size_t i = 0; i < std::min(table.rows(), first.rows()); ++i)
        if (!std::equal(table.row(i), table.row(i) + 3, first.row(i)))
            throw base::InputError(
                fmt::format("{}the point is another one than on line {} of {}; all steps need the "
                            "same points, undisplaced and in the same order",
                            table.place(i), first.lines[i], first.file));
    if (table.rows() != first.rows())
        throw base::InputError(fmt::format(
            "{}{}; all steps need the same points, undisplaced and in the same order",
            table.place(std::min(table.rows() - 1, first.rows())),
            table.rows() > first.rows() ? fmt::format("the point is not in {}", first.file)
                                        : fmt::format("is the last of {} points, but {} has {}",
                                                      table.rows(), first.file, first.rows())));
}

}  // namespace

std::vector<StepFiles> step_files(const std::vector<std::string>& displacements,
                                  const StepOutputs& patterns) {
    check_pattern("--output", patterns.cage, displacements.size());
    check_pattern("--cad-out", patterns.cad, displacements.size());
    check_pattern("--grid-out", patterns.grid, displacements.size());
    check_pattern("--velocities-out", patterns.velocities, displacements.size());
    std::vector<StepFiles> steps;
    std::map<std::string, std::string> known;
    for (const std::string& file : displacements) {
        const std::string step = std::filesystem::path(file).stem().string();
        const auto [other, is_new] = known.try_emplace(step, file);
        if (!is_new)
            throw base::UsageError(fmt::format("{} and {}: {} is '{}' for both; rename one of them",
                                               other->second, file, step_placeholder, step));
        steps.push_back({file,
                         {named(patterns.cage, step_placeholder, step),
                          named(patterns.cad, step_placeholder, step),
                          named(patterns.grid, step_placeholder, step),
                          named(patterns.velocities, step_placeholder, step)}});
    }
    return steps;
}

void add_files(RunFiles& files, const std::vector<StepFiles>& steps) {
    for (const auto& [displacements, outputs] : steps) {
        files.inputs.push_back(displacements);
        files.outputs.push_back({"--output", outputs.cage, OutputKind::Cage});
        files.outputs.push_back({"--cad-out", outputs.cad, OutputKind::Cad});
        files.outputs.push_back({"--grid-out", outputs.grid, OutputKind::Grid});
        files.outputs.push_back({"--velocities-out", outputs.velocities, OutputKind::Table});
    }
}

std::vector<Table> read_steps(const std::vector<StepFiles>& steps) {
    std::vector<Table> tables;
    for (const StepFiles& step : steps) {
        tables.push_back(read_displacements(step));
        check_same_points(tables.front(), tables.back());
    }
    return tables;
}

}  // namespace patchwright::cli
