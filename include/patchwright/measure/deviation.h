// Two-sided deviation of two CAD models.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/model_surface.h>
#include <patchwright/measure/deviation_statistics.h>

namespace patchwright::measure {

struct DeviationMeasure {
    int samples = 20000;  ///< on the faces, about
    /// Also compute measure::Deviation::bound; takes about as long as 100,000 samples and more.
    bool with_bound = true;
    base::Progress progress;
};

/// From `from`, sampled, to the nearest points of `to`, whatever their side. Statistics are
/// weighted by area; points on edges and vertices count for the maximum only.
/// @throw InvalidArgument when there are no samples
measure::Deviation measure_deviation(const geom::ModelSurface& from, const geom::ModelSurface& to,
                                     const DeviationMeasure& options = {});

/// A distance that no point of `from` exceeds, to be put into measure::Deviation::bound afterwards.
/// @param found_mm  the largest distance that is known, from samples
double measure_bound(const geom::ModelSurface& from, const geom::ModelSurface& to, double found_mm,
                     const base::Progress& progress = {});

/// From the feature curves of one kind of `from`, sampled evenly by length, to the nearest ones of
/// `to`; `face` is the number of the curve. Nothing when one of them has no such curve.
/// @throw InvalidArgument when there are no samples
std::optional<measure::Deviation> measure_feature_deviation(const geom::ModelSurface& from,
                                                            const geom::ModelSurface& to,
                                                            geom::FeatureKind kind,
                                                            int samples = 5000);

/// A sharp curve of one model and how far another one's sharp edges are from it.
struct SharpCurveDistance {
    int curve = -1;         ///< number among Features::curves of `from`
    double length = 0.0;    ///< millimetres
    double distance = 0.0;  ///< largest one of its points from the nearest edge that counts;
                            ///< infinite when there is none
    geom::Vec3 at = geom::Vec3::Zero();  ///< where that is
};

/// Sharp curves of `from` longer than `longer_than_mm` against the creases of `to`: its sharp edges
/// and those along which its faces meet at more than a degree somewhere. For a curve whose faces
/// meet at less than a sharp edge's angle on a part of it, all edges of `to` count.
/// @return one a curve, in the order of Features::curves
std::vector<SharpCurveDistance> measure_sharp_curves(const geom::ModelSurface& from,
                                                     const geom::ModelSurface& to,
                                                     double longer_than_mm);

}  // namespace patchwright::measure
