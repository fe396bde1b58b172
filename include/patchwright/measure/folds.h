// Places where a surface faces elsewhere than the shape that it approximates.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/geom/bspline.h>
#include <patchwright/geom/reference_surface.h>
#include <patchwright/measure/verdict.h>

#include <optional>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::measure {

struct FoldOptions {
    double tolerance_mm = 0.0;  ///< size of the neighbourhood of sharp edges; positive
    /// Normals of input and output that differ by more than this disagree.
    double angle_rad = fold_limit_rad;
    /// Creases of the output, beside which normals may turn.
    std::vector<geom::BsplineCurve> creases;
    /// The whole output may face the other way, as open shells do; decided by the larger area.
    bool may_face_away = false;
    base::Progress progress;
};

struct Fold {
    geom::Vec3 point = geom::Vec3::Zero();
    int face = 0;            ///< of the sample
    double angle_rad = 0.0;  ///< least one between its normal and one of the input's nearby
};

struct FoldFigures {
    int samples = 0;            ///< with a normal
    int folded = 0;             ///< of these
    std::optional<Fold> worst;  ///< with the largest angle, the first of equal ones
    std::vector<Fold> by_face;  ///< the worst one of each face that has any, in order
};

/// Looks at 4 x 4 samples in every knot span. A sample is folded when no point of the input within
/// its distance plus two tolerances has a normal that agrees, and neither a sharp or free curve of
/// the input nor a crease of the output lies within the tolerance. Samples of a span that turn by
/// less than a third of the limit are settled by one of them where it is so far from the limit.
/// @throw InvalidArgument when the tolerance or the angle is not positive
/// @throw Cancelled when `progress` says stop
FoldFigures find_folds(const std::vector<geom::BsplineSurface>& surfaces,
                       const geom::ReferenceSurface& input, const FoldOptions& options);

}  // namespace patchwright::measure
#pragma GCC visibility pop
