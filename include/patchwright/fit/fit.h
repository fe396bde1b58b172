// Fits a cage to a reference surface: project the limit points, solve, refine until it is near
// enough.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/reference_surface.h>
#include <patchwright/mesh/cage.h>

#include <algorithm>
#include <vector>

namespace patchwright::fit {

/// A plane through the origin that a half model ends on.
enum class Symmetry { None, Detect, X, Y, Z };

/// How a cage grows.
enum class Refinement {
    Global,  ///< every face is split in four, which leaves the limit surface as it is
    Local    ///< strips of quads across places that are too coarse are split lengthwise
};

struct FitOptions {
    double tolerance_mm = 0.1;  ///< largest allowed distance of limit points to the reference
    Refinement refinement = Refinement::Local;
    int max_levels = 12;        ///< refinements at most
    int max_vertices = 200000;  ///< no refinement beyond this many control points
    /// The fit ends after so many levels in a row that came no nearer than the best one.
    int max_idle_levels = 12;
    /// A face that was split and still has more than this share of its distance is given one more
    /// chance, then none: what is left there is a feature that the cage lacks. Smooth regions gain
    /// a factor of four to sixteen.
    double least_gain = 0.6;
    int max_projections =
        30;  ///< project-and-solve rounds on one level; half as many on its curves
    /// Points of the reference that are looked for on the limit surface, about as many; of
    /// references that can be sampled.
    int reverse_samples = 20000;
    int samples_per_edge = 4;  ///< a face has this squared, a crease edge this many samples; >= 2
    int max_cgls_iterations = 300;
    /// A solve ends when a step of it moves no control point by more than this share of the
    /// tolerance: three hundred such steps add up to 3 % of it.
    double least_change = 1e-4;
    /// Factor of the bending energy in the first step of a level, >= 0; after every step that is
    /// taken it is a fifth of what it was.
    double fairness = 1e-2;
    /// What slides within the surface is held to the given cage, most of all in faces that are
    /// about to fold. Of use where somebody has thought about that cage's form.
    bool keeps_form = true;
    /// A chain of crease or boundary edges belongs to the features of its kind when its mean
    /// distance from them is at most this fraction of the reference's diagonal, or a tenth of its
    /// own length; else it is fitted like the surface. Corners reach this far for corners of the
    /// reference, or a quarter of their shortest chain.
    double feature_reach_rel = 0.05;
    /// Control points on the plane stay on it; where the reference meets it at right angles all
    /// along a chain of sharp edges, the limit surface does so exactly.
    Symmetry symmetry = Symmetry::Detect;
    base::Progress progress;
};

/// What happened on one level of refinement; distances are those of all samples, after fitting.
struct FitLevel {
    int vertices = 0;
    int faces = 0;
    bool local = false;  ///< made by splitting some strips of the level before
    int samples = 0;
    int projections = 0;
    int cgls_steps = 0;
    int solves_by_length = 0;  ///< that ended because no control point moved any more
    int solves_by_steps = 0;   ///< that ended after FitOptions::max_cgls_iterations
    double rms_mm = 0.0;
    double max_mm = 0.0;          ///< of limit points from the reference
    double reverse_max_mm = 0.0;  ///< of points of the reference from the limit surface
    double curve_max_mm = 0.0;    ///< of chains from the feature curves that they belong to
    int chains_on_features = 0;
    double seconds = 0.0;

    [[nodiscard]] double largest() const {
        return std::max({max_mm, reverse_max_mm, curve_max_mm});
    }
};

struct FitResult {
    mesh::Cage cage;
    bool met = false;        ///< FitLevel::largest of the best level is within the tolerance
    int best_level = 0;      ///< the one whose cage this is: no later one came nearer
    int symmetry_axis = -1;  ///< of the symmetry plane that was kept; -1: none
    /// The cage faces the other way than the reference, as open ones can: normals were compared
    /// the other way round. The cage is not turned.
    bool faces_away = false;
    std::vector<FitLevel> levels;
};

/// Moves the control points so that the limit surface lies on the reference: samples inside the
/// faces go to their foot points (on the side their own normal faces); chains of infinitely sharp
/// edges to the sharp feature curves that lie along them, boundaries to free ones, corners to
/// feature corners, where they then end exactly. Steps minimise distances along normals (tangent
/// distance) and bending; one that makes things worse is not taken. Where points of the reference
/// stay beyond the tolerance, samples near them are drawn to them; they count in FitLevel::largest.
/// Steps that would fold faces are made again with these held to the form that they have.
/// Crease and boundary control points are solved first, for their own curves, and then held;
/// creases follow smooth edges of the reference where no sharp ones are as near.
/// A crease that ends within the surface ends where its curve does, within the tolerance, if the
/// curve's end is as near as the crease's last edge is long.
/// Pinned control points do not move. Points at tagged sectors are settled after each level (see
/// subd::control_normals). Missing the tolerance is an answer: see FitResult::met.
/// @throw InvalidArgument when an option is out of range
/// @throw Cancelled when the progress callback says so
FitResult fit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
              const FitOptions& options = {});

}  // namespace patchwright::fit
