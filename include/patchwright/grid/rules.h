// Rules for single block edges, as text.
#pragma once

#include <patchwright/base/units.h>
#include <patchwright/grid/plan.h>

#include <map>
#include <string>
#include <string_view>

#pragma GCC visibility push(default)
namespace patchwright::grid {

/// By their names.
const std::map<std::string, Law>& spacing_laws();

/// Reads rules: a JSON array of objects. "at": [x, y, z] (in `unit`) picks the block edge whose
/// points come nearest; with "only": true it alone has the rule, else all edges that lines connect
/// to it. "cells": a number; "spacing": a law's name; "near", "far": lengths of the cells at the
/// edge's end nearer to the point and at the other one.
/// @throw InputError when it is no such array, naming the rule that is wrong
std::vector<EdgeRule> parse_rules(std::string_view text, const BlockLayout& layout,
                                  base::LengthUnit unit, double diagonal_mm);

}  // namespace patchwright::grid
#pragma GCC visibility pop
