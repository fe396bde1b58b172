// Points of the limit surface that caps are compared with.
#pragma once

#include <patchwright/geom/types.h>
#include <patchwright/subd/limit_mask.h>

#include <map>
#include <mutex>
#include <span>
#include <tuple>

namespace patchwright::patch {

/// Points of the limit surface that caps are fitted to, and others that they are measured at.
enum class Samples { Fit, Check };

/// Their parameters along both edges of a face at the vertex, as shares of the cap's size.
std::span<const double> shares_of(Samples samples);

/// Evaluates the limit surface beside corners of faces, at all pairs of shares, those along the
/// edge that leaves the corner first; one row each. Thread-safe: masks are made once a kind of
/// face.
class LimitSampler {
  public:
    /// @param ring  points of the face's ring, as many as the kind has slots
    [[nodiscard]] geom::Points points(const subd::RingKind& kind, int corner,
                                      const geom::Points& ring, Samples samples);
    /// Unit normals; zero where there is none.
    [[nodiscard]] geom::Points normals(const subd::RingKind& kind, int corner,
                                       const geom::Points& ring, Samples samples);

  private:
    enum class Value { Position, AlongU, AlongV };  // in the order of subd::RingMask
    const Eigen::MatrixXd& masks_of(const subd::RingKind& kind, int corner, Samples samples,
                                    Value value);

    std::mutex mutex_;
    std::map<std::tuple<const subd::RingKind*, int, Samples, Value>, Eigen::MatrixXd> masks_;
};

}  // namespace patchwright::patch
