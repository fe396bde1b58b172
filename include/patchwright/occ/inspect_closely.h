// What a closer look at a CAD model finds: small parts, tolerances, features, mass, overlaps.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/types.h>
#include <patchwright/occ/cad_model.h>

#include <array>
#include <optional>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::occ {

/// Lengths in millimetres; numbers of faces count from 0.
struct CloseInspection {
    int smallest_face = 0;
    double smallest_area_mm2 = 0.0;
    struct NarrowFace {
        int face = 0;
        double width_mm = 0.0;  ///< twice the area by the perimeter
    };
    std::optional<NarrowFace> narrowest;  ///< of the faces with edges
    struct ShortEdge {
        double length_mm = 0.0;
        geom::Vec3 at = geom::Vec3::Zero();
    };
    std::optional<ShortEdge> shortest_edge;

    double vertex_tolerance_mm = 0.0, edge_tolerance_mm = 0.0,
           face_tolerance_mm = 0.0;  ///< largest
    std::optional<OpenGaps> open_gaps;

    int sharp_edges = 0, smooth_edges = 0;
    int sharp_curves = 0, free_curves = 0, corners = 0;
    int kinked_faces = 0;           ///< with a surface that has kinks inside
    double largest_kink_rad = 0.0;  ///< across smooth edges
    geom::Vec3 largest_kink_at = geom::Vec3::Zero();

    /// Of the volume when there are solids, else of the surface.
    geom::Vec3 centre_of_mass = geom::Vec3::Zero();
    /// Of density 1, least first; mm^5 for volumes, mm^4 for surfaces.
    std::array<double, 3> principal_moments{0.0, 0.0, 0.0};

    int named_faces = 0, coloured_faces = 0;
    /// Pairs of solids of which one reaches into the other; numbers count from 0.
    std::vector<std::array<int, 2>> overlapping_solids;
};

struct CloseInspectionOptions {
    double sharp_angle_rad = 0.349;
    base::Progress progress;
};

/// @throw InputError when the model has no faces of finite size
CloseInspection inspect_closely(const CadModel& model, const CloseInspectionOptions& options = {});

/// Solids of which one reaches into the other by more than 1e-5 of the smaller one's diagonal, as
/// sampled at points of their faces, edges and vertices. Solids that merely touch do not count.
std::vector<std::array<int, 2>> overlapping_solids(const CadModel& model,
                                                   const base::Progress& progress = {});

}  // namespace patchwright::occ
#pragma GCC visibility pop
