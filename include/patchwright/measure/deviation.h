// Two-sided deviation of two CAD models.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/bspline.h>
#include <patchwright/geom/model_surface.h>
#include <patchwright/measure/deviation_statistics.h>

#pragma GCC visibility push(default)
namespace patchwright::measure {

struct DeviationMeasure {
    int samples = 20000;     ///< on the faces, about
    bool with_bound = true;  ///< also Deviation::bound, with the defaults of BoundOptions
    base::Progress progress;
};

/// Between planes with these unit normals, 0 to pi/2, whatever their side: nearest points of thin
/// parts may lie on the other side. Nothing where a normal is zero.
std::optional<double> tangent_plane_angle(const geom::Vec3& a, const geom::Vec3& b);

/// From `from`, sampled, to the nearest points of `to`, whatever their side. Statistics are
/// weighted by area; points on edges and vertices count for the maximum only.
/// @throw InvalidArgument when there are no samples
/// @throw Cancelled when the progress callback asks for it
Deviation measure_deviation(const geom::ModelSurface& from, const geom::ModelSurface& to,
                            const DeviationMeasure& options = {});

struct BoundOptions {
    /// The largest distance that is known, from samples, mm: the bound is refined towards it and
    /// is never less.
    double found_mm = 0.0;
    /// Pieces are refined until this many foot points were looked for, or the bound is near enough.
    /// Before that, one is looked for in each corner and in the middle of each piece of `from`.
    /// The files of samples/README.md need 5,000 to 40,000; raise it when the bound is far above
    /// the samples.
    int foot_points = 100000;
    base::Progress progress;
};

/// A distance that no point of `from` exceeds, mm, to be put into Deviation::bound.
/// Position, normal and curvature of both models in the corners of a piece limit what lies between
/// (src/measure/second_order.h); a foot point in its middle checks that; both count one and a half
/// times. Pieces with large bounds are quartered. So this is a bound for shapes that do not bend in
/// wholly new ways between samples, not a proof. The faces' boundary curves are bounded alike.
/// (Compare Tang, Lee, Kim, Interactive Hausdorff distance computation for general polygonal
/// models, 2009, for quartering.)
/// @throw InvalidArgument when the options are out of range
/// @throw Cancelled when the progress callback asks for it, TimeLimitReached when it throws that
///        before all pieces were looked at once; later, the bound is what it is by then
double measure_bound(const geom::ModelSurface& from, const geom::ModelSurface& to,
                     const BoundOptions& options = {});

/// The largest distance of points of a B-spline surface from a reference, mm.
/// @param samples  along each of u and v, in the middles of equal intervals
/// @throw InvalidArgument when there are no samples
double largest_deviation(const geom::BsplineSurface& surface,
                         const geom::ReferenceSurface& reference, int samples = 12);

struct FeatureMeasure {
    int samples = 5000;  ///< on all curves of the kind together, about
    base::Progress progress;
};

/// From the feature curves of one kind of `from`, sampled evenly by length, to the nearest ones of
/// `to`; Deviation::face is the number of the curve. Nothing when one of them has no such curve.
/// @throw InvalidArgument when there are no samples
/// @throw Cancelled when the progress callback asks for it
std::optional<Deviation> measure_feature_deviation(const geom::ModelSurface& from,
                                                   const geom::ModelSurface& to,
                                                   geom::FeatureKind kind,
                                                   const FeatureMeasure& options = {});

/// A sharp curve of one model and how far another one's sharp edges are from it.
struct SharpCurveDistance {
    int curve;              ///< number among Features::curves of `from`
    double length = 0.0;    ///< millimetres
    double distance = 0.0;  ///< mm, largest one of its points from the nearest edge that counts;
                            ///< infinite when there is none
    geom::Vec3 at = geom::Vec3::Zero();  ///< where that is
};

/// Sharp curves of `from` longer than `longer_than_mm` against where `to` is not smooth: its sharp
/// and free edges and those along which its faces meet at more than a degree somewhere. For a curve
/// whose faces meet at less than a sharp edge's angle on a part of it, all edges of `to` count.
/// @return one a curve, in the order of Features::curves
/// @throw Cancelled when the progress callback asks for it
std::vector<SharpCurveDistance> measure_sharp_curves(const geom::ModelSurface& from,
                                                     const geom::ModelSurface& to,
                                                     double longer_than_mm,
                                                     const base::Progress& progress = {});

}  // namespace patchwright::measure
#pragma GCC visibility pop
