// What is written of places on a cage.
#pragma once

#include "command.h"
#include "places.h"

#include <patchwright/subd/limit_mask.h>

#include <string>

namespace patchwright::cli {

/// Files of `eval`; empty where not asked for.
struct EvalFiles {
    std::string at_file, output, jacobian, gradient, adjoint;
};

/// Adds what is asked for to the run's outputs, and names the stages.
/// @return  a line a file
/// @throw InputError when gradients are not one a place
std::string write_eval_files(Run& run, const mesh::Cage& cage,
                             const subd::LimitEvaluator& evaluator, const Places& places,
                             const EvalFiles& files);

}  // namespace patchwright::cli
