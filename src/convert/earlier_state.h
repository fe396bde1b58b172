// Cages that are to be fitted again to a model that has changed.
#pragma once

#include <patchwright/convert/source.h>
#include <patchwright/mesh/cage.h>

namespace patchwright::convert {

/// @throw InputError where the cage cannot have been fitted to an earlier state of the model
void check_earlier_state(const mesh::Cage& cage, const Source& source);

/// @throw InputError where the cage's limit surface is not on `earlier`, which it is said to have
///        been fitted to
void check_fitted_to(const mesh::Cage& cage, const Source& earlier, const Source& source);

}  // namespace patchwright::convert
