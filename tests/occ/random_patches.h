// Random cages as the command line would write them, and what is found in the file.
#pragma once

#include "support/cages.h"

#include <patchwright/occ/assemble.h>
#include <patchwright/occ/inspect.h>
#include <patchwright/patch/extract.h>

#include <filesystem>
#include <vector>

namespace patchwright::test {

struct RandomPatches {
    occ::Inspection inspection;
    bool closed = false;  ///< the cage
    double relative_gap = 0.0;
    double kink_deg = 0.0;  ///< over smooth edges but the exempt ones
    int smooth_edges = 0;
    int exempt_edges = 0;  ///< smooth ones that end at a vertex whose cap is not smooth
    int caps = 0, caps_not_smooth = 0;
    int caps_without_plane = 0;  ///< not smooth, as the limit surface itself has no tangent plane
};

/// Open and closed, with creases, corners, darts, semi-sharp edges and polygons of all sizes; every
/// sixth one is a fan of 3 to 12 faces around one vertex.
inline mesh::Cage cage_of_any_kind(unsigned seed) {
    if (seed % 6 == 5) return fan(3 + int(seed / 6) % 10);
    return random_cage(seed, {.open = seed % 2 == 1,
                              .crease_share = 0.1 * (seed % 4),
                              .semi_sharp = seed % 5 == 0,
                              .rule = seed % 4 < 2 ? mesh::BoundaryRule::EdgeOnly
                                                   : mesh::BoundaryRule::EdgeAndCorner});
}

/// Extracts, assembles, writes STEP, reads it back as it is and measures that.
inline RandomPatches write_random_patches(unsigned seed, const std::filesystem::path& file) {
    const mesh::Cage cage = cage_of_any_kind(seed);
    const auto extraction = patch::extract(cage);
    occ::write_cad(occ::assemble(extraction.patches), file);
    const occ::CadModel read = occ::read_cad(file, {.heal = false}).model;

    RandomPatches result;
    result.closed = cage.topology->is_closed();
    result.inspection = occ::inspect(read);
    std::vector<geom::Vec3> middles;
    for (const patch::PatchEdge& edge : extraction.patches.edges) {
        if (edge.continuity != patch::EdgeContinuity::Position) continue;
        middles.push_back(edge.curve.at(0.5 * (edge.curve.begin() + edge.curve.end())));
    }
    geom::Points points(Eigen::Index(middles.size()), 3);
    for (std::size_t k = 0; k < middles.size(); ++k) points.row(Eigen::Index(k)) = middles[k];
    constexpr int samples_an_edge = 65;
    const patch::Continuity all =
        occ::measure_continuity(read, geom::Points(0, 3), {.samples_per_edge = 2});
    const patch::Continuity smooth =
        occ::measure_continuity(read, points, {.samples_per_edge = samples_an_edge});
    result.relative_gap =
        std::max(all.max_gap_mm, smooth.max_gap_mm) / result.inspection.bounds.diagonal();
    result.kink_deg = smooth.max_kink_rad * 180.0 / M_PI;
    result.smooth_edges = smooth.smooth_edges;
    const auto creases = int(patch::crease_midpoints(extraction.patches).rows());
    result.exempt_edges = smooth.crease_edges - creases;
    result.caps = int(extraction.caps.size());
    for (const patch::CapReport& cap : extraction.caps) {
        result.caps_not_smooth += cap.smooth ? 0 : 1;
        result.caps_without_plane += cap.limit_has_plane ? 0 : 1;
    }
    return result;
}

}  // namespace patchwright::test
