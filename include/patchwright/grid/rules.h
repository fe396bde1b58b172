// Rules for single block edges from a file.
#pragma once

#include <patchwright/base/units.h>
#include <patchwright/grid/plan.h>

#include <filesystem>
#include <map>
#include <string>

namespace patchwright::cli {

/// Names of spacing laws.
const std::map<std::string, grid::Law>& spacing_laws();

/// Reads rules: a JSON array of objects. "at": [x, y, z] (in `unit`) picks the block edge whose
/// points come nearest; with "only": true it alone has the rule, else all edges that lines connect
/// to it. "cells": a number; "spacing": a law's name; "near", "far": lengths of the cells at the
/// edge's end nearer to the point and at the other one.
/// @throw InputError when the file cannot be read or a rule is wrong, naming it
std::vector<grid::EdgeRule> read_grid_rules(const std::filesystem::path& file,
                                            const grid::BlockLayout& layout, base::LengthUnit unit,
                                            double diagonal_mm);

}  // namespace patchwright::cli
