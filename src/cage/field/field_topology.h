// Where a cross field is irregular, and how many quads it leaves room for along features.
#pragma once

#include "cage/field/cross_field.h"

#include <string>
#include <vector>

namespace patchwright::cage {

/// An inner vertex with other than four quads, or the tip of a cone.
struct Singularity {
    int vertex = -1;
    int valence = 4;  ///< quads around it: 3 at an index of 1/4, 5 at -1/4
};

/// Between two sides on features or boundaries at a vertex; several at a vertex where features
/// meet.
struct FieldSector {
    int vertex = -1, next = -1;  ///< counter-clockwise from the side vertex - next
    double angle = 0.0;          ///< radians
    int quads = 2;               ///< that there are to be; 2 where a border goes on
    int of_field = 2;            ///< that the field makes room for; less where a cage needs more
};

struct FieldTopology {
    std::vector<Singularity> singularities;
    std::vector<FieldSector> sectors;
    /// One line each region, bounded by features, whose indices do not sum up to its Euler
    /// characteristic: the field is no field of quads there.
    std::vector<std::string> mismatches;
};

/// Source: Ray, Vallet, Li and Levy, N-symmetry direction field design (2008).
FieldTopology field_topology(const geom::EditableMesh& mesh, const CrossField& field);

}  // namespace patchwright::cage
