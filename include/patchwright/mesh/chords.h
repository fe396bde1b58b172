// Chords of a quad mesh: strips of quads that are split lengthwise without new extraordinary
// vertices.
#pragma once

#include <patchwright/mesh/topology.h>

#include <memory>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::mesh {

/// Edges on opposite sides of a quad belong to one chord.
struct Chords {
    std::vector<int> of_edge;
    int count = 0;
};

/// @pre  topology.all_quads()
Chords find_chords(const Topology& topology);

/// A mesh with some chords split, and where it lies in the one it was made from.
struct ChordSplit {
    std::shared_ptr<const Topology> topology;
    struct Origin {
        FaceId face;
        double u = 0.0, v = 0.0;  ///< in the old face: (0,0) at its first vertex, u to the second
    };
    /// One a vertex. Old vertices come first and keep their numbers.
    std::vector<Origin> vertices;
    std::vector<FaceId> parents;  ///< one a face
    /// One an old face: whether it was split across its first and third edge (bit 0), across the
    /// others (bit 1).
    std::vector<int> cuts;
};

/// Every edge of the chosen chords gets a vertex in its middle, and the quads they cross two
/// children or four, with the parent's axes, sharpness and group. Unlike refine() this changes the
/// limit surface.
/// @param chosen  one a chord
/// @pre  topology.all_quads()
ChordSplit split_chords(const Topology& topology, const Chords& chords,
                        const std::vector<char>& chosen);

}  // namespace patchwright::mesh
#pragma GCC visibility pop
