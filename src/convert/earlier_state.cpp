#include "convert/earlier_state.h"

#include <patchwright/base/error.h>
#include <patchwright/subd/limit_mask.h>

#include <fmt/format.h>

#include <algorithm>

namespace patchwright::convert {

namespace {

/// Of the diagonals: models that change by more are another model, or in another unit; the smallest
/// factor between two units is 2.54.
constexpr double largest_ratio = 2.0;
/// Of the diagonal: limit points from what the cage was fitted to. Fits that have missed by less
/// are still fits.
constexpr double farthest_rel = 5e-3;

}  // namespace

void check_earlier_state(const mesh::Cage& cage, const Source& source) {
    const double ratio = geom::bounding_box(cage.points).diagonal() / source.input.diagonal;
    if (!(ratio <= largest_ratio) || ratio * largest_ratio < 1.0)
        throw base::InputError(fmt::format(
            "{}: the cage is {:.3g} times as large as the model: it was not fitted to an earlier "
            "state of it; check its unit and the model's",
            source.input.file, ratio));
    const int borders = mesh::summarise(*cage.topology).boundary_edges;
    if ((borders == 0) == source.figures.closed) return;
    throw base::InputError(
        fmt::format("{}: the model is {} and the cage {}: it was not fitted to an earlier state of "
                    "the model; make a cage with convert or cage",
                    source.input.file, source.figures.closed ? "closed" : "open",
                    borders == 0 ? "closed" : fmt::format("has {} border edges", borders)));
}

void check_fitted_to(const mesh::Cage& cage, const Source& earlier, const Source& source) {
    double farthest = 0.0;
    const subd::LimitEvaluator limit(cage.topology);
    for (const mesh::VertexId v : cage.topology->vertices()) {
        const geom::Vec3 at = limit.position(cage.points, v);
        farthest = std::max(farthest, earlier.surface().foot_point(at).distance);
    }
    if (farthest <= farthest_rel * earlier.input.diagonal) return;
    throw base::InputError(fmt::format(
        "{}: the cage's limit surface is up to {:.2g} of the diagonal from this model: it was not "
        "fitted to it; refit to {} without it, or check the cage's unit and the model's",
        earlier.input.file, farthest / earlier.input.diagonal, source.input.file));
}

}  // namespace patchwright::convert
