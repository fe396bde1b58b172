// One cage fitted to many designs.
#pragma once

#include <patchwright/convert/convert.h>

#pragma GCC visibility push(default)
namespace patchwright::convert {

struct FamilyOptions {
    base::Length tolerance;  ///< of each design
    fit::Symmetry symmetry = fit::Symmetry::Detect;
    SourceOptions reading;  ///< of each design; its progress is not called
    /// What the cage was fitted to: as in refits, cages go with the faces that designs have in
    /// common with it.
    const Source* earlier = nullptr;
};

/// What came of one design.
struct FamilyMember {
    std::filesystem::path file;
    double tolerance_mm = 0.0;
    std::optional<Attempt> attempt;    ///< none: the time limit came first
    std::vector<std::string> notices;  ///< one line each, for the user
    double seconds = 0.0;              ///< of one thread
};

/// Fits the cage to each design as fit_only() does in refits: with the same topology, names and
/// tags. Several designs at a time, each on one thread; members do not depend on the number of
/// threads. The budget's callback is called from the calling thread.
/// @throw InputError when one cannot be read, or the cage was not fitted to an earlier state of it,
///        or not to the one given, or that has other faces
/// @throw Cancelled when the budget's callback says so
std::vector<FamilyMember> fit_family(const mesh::Cage& cage,
                                     const std::vector<std::filesystem::path>& designs,
                                     const FamilyOptions& options,
                                     const base::Budget& budget = base::Budget());

}  // namespace patchwright::convert
#pragma GCC visibility pop
