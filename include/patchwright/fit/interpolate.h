// Cages whose limit surface goes through given points.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/mesh/cage.h>
#include <patchwright/subd/limit_mask.h>

#include <span>

#pragma GCC visibility push(default)
namespace patchwright::fit {

struct InterpolationOptions {
    int max_iterations = 2000;
    /// Largest distance that may remain, relative to the largest distance before.
    double relative_residual = 1e-12;
    base::Progress progress;
};

struct InterpolationResult {
    mesh::Cage cage;
    int iterations = 0;
    double largest_distance = 0.0;  ///< of a limit point to its target, millimetres
    bool met = false;
};

/// The cage nearest to this one, in the sum of squares of its points' displacements, whose limit
/// points at these places are the targets. Contradicting targets give the least-squares answer and
/// met = false.
/// @param targets  one row a place
/// @throw InvalidArgument when sizes differ or a place is not on the mesh
InterpolationResult interpolate(const mesh::Cage& cage, std::span<const subd::Location> places,
                                const geom::Points& targets,
                                const InterpolationOptions& options = {});

/// The same for the limit positions of all vertices: one target a vertex.
InterpolationResult interpolate_vertices(const mesh::Cage& cage, const geom::Points& targets,
                                         const InterpolationOptions& options = {});

}  // namespace patchwright::fit
#pragma GCC visibility pop
