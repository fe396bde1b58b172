// Statistics of distances between two shapes.
#pragma once

#include <patchwright/geom/types.h>

#include <optional>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::measure {

/// A sample far from the other shape.
struct DeviationPlace {
    geom::Vec3 point = geom::Vec3::Zero();
    int face;               ///< of the sampled shape
    double distance = 0.0;  ///< mm
};

/// The samples on one face.
struct DeviationOfFace {
    int face = 0;  ///< of the sampled shape
    int samples = 0;
    double max = 0.0, rms = 0.0;  ///< mm
    /// Angles between the tangent planes of both shapes, 0 to pi/2; nothing where no sample has
    /// one.
    std::optional<double> normal_max_rad, normal_rms_rad;
};

/// Shares of the weight by distance: bin i holds distances from i to i + 1 times the width.
struct Histogram {
    double width = 0.0;  ///< mm
    std::vector<double> shares;
};

/// Distances of sample points on one shape to the nearest point of another, in millimetres.
struct Deviation {
    double max = 0.0;
    double rms = 0.0;
    double p50 = 0.0;
    double p95 = 0.0;
    double p99 = 0.0;
    /// No point of the sampled shape is farther, samples or not; see measure_bound().
    std::optional<double> bound;
    geom::Vec3 at = geom::Vec3::Zero();  ///< where on the sampled shape the maximum lies
    std::optional<int> face;             ///< the sampled shape's face there, when there are samples
    int samples = 0;
    /// The largest distances at places that are some way apart, largest first; `at` is the first.
    std::vector<DeviationPlace> worst;
    /// By number; faces without samples are left out. Empty of curves, like the histogram.
    std::vector<DeviationOfFace> faces;
    Histogram histogram;
};

struct DistanceSample {
    geom::Vec3 point;
    int face;
    double distance;
    double weight = 1.0;                     ///< area or length that the sample stands for
    std::optional<double> normal_angle_rad;  ///< between the tangent planes of both shapes
};

struct DeviationOptions {
    int places = 5;         ///< entries of Deviation::worst at most
    double apart_mm = 0.0;  ///< least distance between them
    int histogram_bins = 32;
    bool of_faces = false;  ///< also Deviation::faces and the histogram
};

/// Percentiles are the smallest distances that at least that share of the weight does not exceed;
/// the mean square is weighted too.
Deviation deviation_statistics(const std::vector<DistanceSample>& samples,
                               const DeviationOptions& options = {});

}  // namespace patchwright::measure
#pragma GCC visibility pop
