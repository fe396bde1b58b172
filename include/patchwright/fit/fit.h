// Fits a cage to a reference surface: project the limit points, solve, refine until the tolerance
// is met.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/reference_surface.h>
#include <patchwright/mesh/cage.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::fit {

/// A plane through the origin that a half model ends on.
enum class Symmetry { None, Detect, X, Y, Z };

/// How a cage grows.
enum class RefinementScope {
    Global,  ///< every face is split in four, which leaves the limit surface as it is
    Local    ///< strips of quads across places that are too coarse are split lengthwise
};

/// Of the reference's diagonal: how far interpolated limit points may be from their targets.
inline constexpr double interpolation_limit_rel = 1e-9;

struct FitOptions {
    /// Largest allowed distance between the limit surface and the reference, both ways.
    double tolerance_mm = 0.1;
    /// Global keeps the layout of the given cage, at the price of up to four times the faces.
    RefinementScope refinement = RefinementScope::Local;
    /// Refinements at most. Lower it where the number of patches matters more than the tolerance.
    int max_levels = 12;
    /// No refinement beyond this many control points. Raise it for large models, lower it for
    /// memory and time.
    int max_vertices = 200000;
    /// All faces are split only where at least this share of them is to be split: where fewer are,
    /// the fit ends. Raise it where a cage with smaller faces in these places can be made instead.
    double min_share_to_split_all = 0.0;
    /// The fit ends where the next level would have more than this many times the faces of the last
    /// one that gained something. A level of four times the faces of that one gains where it leaves
    /// less than `idle_share` of its distance, one of 4^k times where it leaves less than the k-th
    /// power of that; within the tolerance, where it opens folds. Strips at features narrower than
    /// faces are halved no further than that. Lower both where another cage can be tried instead.
    double max_idle_growth = std::numeric_limits<double>::infinity();
    double idle_share = 1.0;  ///< above 0, at most 1
    /// The parametrisation of the given cage is preserved by tangential regularisation, most of
    /// all in faces that are about to fold. Switch it off where the lines of the cage are not meant
    /// to stay, and keep the fit from coming near.
    bool preserve_parametrisation = true;
    /// About as many points of the reference are looked for on the limit surface, where the
    /// reference can be sampled. Raise it where features are smaller than the distance between
    /// these points; 0: distances are measured from the limit surface only.
    int reverse_samples = 20000;
    /// A chain of crease or boundary edges belongs to the features of its kind when its mean
    /// distance from them is at most this fraction of the reference's diagonal, or a tenth of its
    /// own length; else it is fitted like the surface. Corners reach this far for corners of the
    /// reference, or a quarter of their shortest chain. Raise it for cages that are drawn roughly.
    double feature_reach_rel = 0.05;
    /// Control points on the plane stay on it; where the reference meets it at right angles all
    /// along a chain of sharp edges, the limit surface does so exactly. Name the plane where it is
    /// not found, None where the model only happens to end on it.
    Symmetry symmetry = Symmetry::Detect;
    /// How the surface is to end at creases; none: as the given cage says. See mesh::CreaseRule.
    /// ParabolicRunout is nearer to curved models there; other programs do not know it.
    std::optional<mesh::CreaseRule> crease_rule;
    /// In place of least squares: the limit points of all vertices lie on the reference, as many
    /// conditions as control points (collocation). One level; the tolerance is for FitResult only,
    /// and symmetry is not looked for. See fit().
    bool interpolate = false;
    /// Called from the thread that called fit(), at least once a step of the solver.
    base::Progress progress;

    /// Of the solver. Tests and experiments change these, users need not.
    struct Solver {
        /// Project-and-solve rounds on one level; half as many on its curves.
        int max_projections = 30;
        int samples_per_edge = 4;  ///< a face has this squared, a crease edge as many; >= 2
        int max_cgls_iterations = 300;
        /// A solve ends when a step of it moves no control point by more than this share of the
        /// tolerance: three hundred such steps add up to 3 % of it.
        double step_tolerance_rel = 1e-4;
        /// Factor of the bending energy in the first step of a level, >= 0; after every step that
        /// is taken it is a fifth of what it was.
        double fairness = 1e-2;
        /// Scale of the tangential regularisation in parts of the tolerance: a tangential motion by
        /// the width of a face counts as a distance of this. The larger, the more of the given
        /// parametrisation is preserved. This is enough against drift without cause, too little to
        /// keep curves and leading edges from their place (refinement_test).
        double tangential_scale_rel = 0.1;
        /// Whether the bending energy makes the given lines even while it has weight; else it bends
        /// surfaces only, and lines that gather on purpose, as at wing tips, stay so.
        bool evens_lines = true;
    };
    Solver solver;
};

/// What happened on one level of refinement; distances are those of all samples to their foot
/// points, after fitting.
struct FitLevel {
    int vertices = 0;
    int faces = 0;
    bool local = false;  ///< made by splitting some strips of the level before
    int samples = 0;
    int projections = 0;
    int cgls_steps = 0;
    int solves_by_step_tolerance = 0;  ///< that ended because no control point moved any more
    int solves_by_max_iterations = 0;  ///< that ended after Solver::max_cgls_iterations
    double rms_mm = 0.0;
    double max_mm = 0.0;          ///< of limit points from the reference
    double reverse_max_mm = 0.0;  ///< of points of the reference from the limit surface
    double curve_max_mm = 0.0;    ///< of chains from the feature curves that they belong to
    /// Where those largest ones are; undefined where they are zero.
    geom::Vec3 max_at = geom::Vec3::Zero(), reverse_max_at = max_at, curve_max_at = max_at;
    int chains_on_features = 0;
    /// Samples that are folded, beyond the tolerance from sharp edges (see measure::find_folds);
    /// looked for where all distances are within the tolerance.
    int folded = 0;
    /// With FitOptions::interpolate: of the limit points of vertices from their targets.
    std::optional<double> interpolated_mm;
    double seconds = 0.0;

    [[nodiscard]] double largest() const {
        return std::max({max_mm, reverse_max_mm, curve_max_mm});
    }
};

struct FitResult {
    mesh::Cage cage;
    /// Whether FitLevel::largest of the best level is; the verdict on a result asks for more.
    bool within_tolerance = false;
    /// The one whose cage this is: the nearest one, of those within the tolerance the first one
    /// with fewest folds.
    int best_level = 0;
    std::optional<int> symmetry_axis;  ///< of the symmetry plane that was kept: 0, 1 or 2
    /// The normals of the cage point against those of the reference, as those of open ones can:
    /// they were compared with reversed signs. The cage keeps its orientation.
    bool faces_away = false;
    /// The progress callback threw base::TimeLimitReached: the best level so far was taken. The
    /// first level counts as far as it came.
    bool stopped_by_time_limit = false;
    /// Of the best level: middles of the control polygons of faces that are beyond the tolerance or
    /// folded, the farthest ones first.
    std::vector<geom::Vec3> misses;
    std::vector<FitLevel> levels;
};

/// Moves the control points so that the limit surface lies on the reference: samples inside the
/// faces go to their foot points (on the side that their own normals point to, and where sharp
/// curves part the reference, to those on the part that the creases around a face tell); chains of
/// infinitely sharp edges to the sharp feature curves that lie along them, boundaries to free ones,
/// corners to feature corners, where they then end exactly. Steps minimise distances along normals
/// (tangent distance) and bending energy; a step that increases their sum is not taken. Where
/// points of the reference stay beyond the tolerance, samples near them get them as targets; they
/// count in FitLevel::largest. Where a step would invert faces their control points take shorter
/// ones; faces that are folded when a level begins are evened out, and a fit within the tolerance
/// goes on while that opens folds. At corners of three or four quads what would make the limit
/// surface run over a crease is kept out (see subd::CornerSectors).
/// Crease and boundary control points are solved first, for their own curves, and then held, with
/// those beside them carried along; creases follow smooth edges of the reference where no sharp
/// ones are as near and these are not quite smooth somewhere. Chains keep the order along their
/// curves, however near those come to themselves; a cage whose chains belong farther away than
/// their edges are long is moved there as a whole first. A crease that ends within the surface ends
/// where its curve does, within the tolerance, if the curve's end is as near as the crease's last
/// edge is long. Pinned control points do not move. Points at tagged sectors are settled after each
/// level (see subd::control_normals). Missing the tolerance is an answer: see
/// FitResult::within_tolerance.
/// With FitOptions::interpolate the limit points of the given cage go to their foot points on the
/// reference (Brakhage, Grid generation and grid conversion by subdivision schemes, section 3:
/// projected limit points as collocation points), those on chains to their curves, and corners to
/// corners; of all cages that do so the nearest to the given one is taken.
/// @throw InvalidArgument when an option is out of range
/// @throw InputError when interpolation meets pinned vertices or tagged sectors, or when its limit
///        points cannot all be reached to interpolation_limit_rel, as at cages of valence 3 only,
///        whose masks depend on each other
/// @throw Cancelled when the progress callback says so
/// @throw TimeLimitReached when the callback does before there is any level to return
FitResult fit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
              const FitOptions& options = {});

}  // namespace patchwright::fit
#pragma GCC visibility pop
