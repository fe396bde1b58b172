// Fewer triangles where a field has more than a page can hold.
#pragma once

#include <patchwright/measure/field.h>

namespace patchwright::report {

/// The field with at most `most_vertices`, which are some of its own: of those of a face that are
/// in one cube of a grid and face about the same way, the one with the largest distance stands for
/// all. Lines keep as many points as there are vertices at most.
/// @pre most_vertices is positive
measure::Field thin_field(const measure::Field& field, int most_vertices);

}  // namespace patchwright::report
