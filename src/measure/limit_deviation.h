// How far a limit surface is from a reference and the reference from it, face by face.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/reference_surface.h>
#include <patchwright/mesh/cage.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <vector>

namespace patchwright::measure {

/// Sums over distances of samples.
struct Distances {
    double sum_of_squares = 0.0;  ///< mm^2
    double max = 0.0;             ///< mm
    geom::Vec3 max_at = geom::Vec3::Zero();
    std::int64_t count = 0;

    void add(double distance, const geom::Vec3& at) {
        sum_of_squares += distance * distance;
        raise(distance, at);
        ++count;
    }
    void add(const Distances& others) {
        sum_of_squares += others.sum_of_squares;
        raise(others.max, others.max_at);
        count += others.count;
    }
    void raise(double distance, const geom::Vec3& at) {
        if (distance <= max) return;
        max = distance;
        max_at = at;
    }
    [[nodiscard]] double rms() const {
        return count > 0 ? std::sqrt(sum_of_squares / double(count)) : 0.0;
    }
};

/// Of a face's samples; where a cage has other faces than quads, of all their sectors together.
struct FaceDeviation {
    double max = 0.0;      ///< mm, from the reference
    double reverse = 0.0;  ///< mm, of points of the reference to which the face is nearest
    Eigen::Vector2d reverse_at = Eigen::Vector2d::Zero();  ///< its limit point, in the face
    /// Of all such limit points that are farther away than LimitDeviationOptions::far_mm.
    Eigen::AlignedBox<double, 2> beyond;
    int beyond_count = 0;
    /// How much the distance vector changes along u and along v, mm^2: which direction is too
    /// coarse.
    double change_u = 0.0, change_v = 0.0;
};

struct LimitDeviation {
    Distances surface;  ///< of limit points from the reference
    Distances reverse;  ///< of points of the reference from the limit surface
    std::vector<FaceDeviation> faces;
};

struct LimitDeviationOptions {
    int intervals = 8;  ///< of a face's side: (intervals + 1)^2 limit points a face or sector
    /// Beyond which points of the reference are counted one by one.
    double far_mm = 0.0;
    base::Progress progress;
};

/// On a grid over all faces, borders included.
/// @param points  of the reference, to be looked for on the limit surface
/// @throw Cancelled when the progress callback asks for it
LimitDeviation measure_limit(const mesh::Cage& cage, const geom::ReferenceSurface& reference,
                             const std::vector<geom::Vec3>& points,
                             const LimitDeviationOptions& options);

}  // namespace patchwright::measure
