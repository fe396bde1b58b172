// What a grid is refined by, along whole lines.
#pragma once

#include <patchwright/adapt/sensor.h>
#include <patchwright/adapt/size_field.h>
#include <patchwright/grid/plan.h>

#include <optional>

#pragma GCC visibility push(default)
namespace patchwright::adapt {

/// A side of a cell is too long where any of these says so.
struct Criteria {
    /// It is longer than the size at its middle.
    std::optional<SizeField> sizes;
    /// The quantity jumps along it, by way of its middle, by more than this share of its range: the
    /// undivided difference, which equal errors everywhere keep equal.
    /// Source: Dannenhoffer and Baron, Grid adaptation for the 2-D Euler equations (1985).
    std::optional<Sensor> sensor;
    double sensor_jump = 0.05;
    /// Nothing shorter comes of halving it, else a shock would be refined for ever.
    double smallest_mm = 0.0;
};

/// How many times too large; above 1 the side is too long.
/// @throw InvalidArgument when there is no criterion, or a number is out of range
grid::LineError refinement_error(const Criteria& criteria);

/// Halves cells along whole lines until no cell's side is too long, or for so many rounds; spacing
/// laws are kept in between.
/// @throw UsageError when the grid would not fit into memory, Cancelled
grid::Plan refined(const grid::Plan& plan, const Criteria& criteria,
                   const grid::RefineOptions& options = {});

}  // namespace patchwright::adapt
#pragma GCC visibility pop
