// Options that say how a grid's blocks are cut and how many points they have.
#pragma once

#include <patchwright/grid/plan.h>

#include <CLI/CLI.hpp>

#include <string>

namespace patchwright::cli {

struct BlockArguments {
    std::string blocks = "groups";
    bool no_join = false;
    std::string size;  ///< empty: by points
    int points = 17;
};

void add_block_options(CLI::App& command, BlockArguments& options);

/// @throw as grid::make_layout()
grid::BlockLayout make_layout(const mesh::Cage& cage, const BlockArguments& options);

/// With nothing but numbers of cells.
grid::PlanOptions plan_options(const BlockArguments& options, double diagonal_mm);

}  // namespace patchwright::cli
