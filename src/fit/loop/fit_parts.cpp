#include <patchwright/base/error.h>
#include <patchwright/fit/fit_parts.h>
#include <patchwright/mesh/parts.h>

#include <algorithm>
#include <cmath>

namespace patchwright::fit {

namespace {

/// What part stands for level number `level` of `count`.
const FitLevel& level_of(const FitResult& part, std::size_t level, std::size_t count) {
    const std::size_t last = part.levels.size() - 1;
    return part.levels[level + 1 == count ? std::size_t(part.best_level) : std::min(level, last)];
}

void raise(double& max, geom::Vec3& at, double value, const geom::Vec3& place) {
    if (value <= max) return;
    max = value;
    at = place;
}

FitLevel sum_of(const std::vector<FitResult>& parts, std::size_t level, std::size_t count) {
    FitLevel sum;
    double squares = 0.0;
    for (const FitResult& part : parts) {
        const FitLevel& one = level_of(part, level, count);
        sum.vertices += one.vertices;
        sum.faces += one.faces;
        sum.samples += one.samples;
        sum.local = sum.local || one.local;
        squares += double(one.samples) * one.rms_mm * one.rms_mm;
        raise(sum.max_mm, sum.max_at, one.max_mm, one.max_at);
        raise(sum.reverse_max_mm, sum.reverse_max_at, one.reverse_max_mm, one.reverse_max_at);
        raise(sum.curve_max_mm, sum.curve_max_at, one.curve_max_mm, one.curve_max_at);
        sum.chains_on_features += one.chains_on_features;
        sum.folded += one.folded;
        if (one.interpolated_mm)
            sum.interpolated_mm = std::max(sum.interpolated_mm.value_or(0.0), *one.interpolated_mm);
        if (level >= part.levels.size()) continue;
        const FitLevel& worked = part.levels[level];
        sum.projections += worked.projections;
        sum.cgls_steps += worked.cgls_steps;
        sum.solves_by_step_tolerance += worked.solves_by_step_tolerance;
        sum.solves_by_max_iterations += worked.solves_by_max_iterations;
        sum.seconds += worked.seconds;
    }
    sum.rms_mm = sum.samples > 0 ? std::sqrt(squares / double(sum.samples)) : 0.0;
    return sum;
}

}  // namespace

FitResult joined(const std::vector<FitResult>& parts) {
    if (parts.empty()) throw base::InvalidArgument("joined: no parts of a fit");
    FitResult whole{.within_tolerance = true, .symmetry_axis = parts.front().symmetry_axis};
    std::vector<mesh::Cage> cages;
    std::size_t levels = 0;
    for (const FitResult& one : parts) {
        cages.push_back(one.cage);
        levels = std::max(levels, one.levels.size());
        whole.within_tolerance = whole.within_tolerance && one.within_tolerance;
        whole.faces_away = whole.faces_away || one.faces_away;
        whole.stopped_by_time_limit = whole.stopped_by_time_limit || one.stopped_by_time_limit;
        if (one.symmetry_axis != whole.symmetry_axis) whole.symmetry_axis.reset();
    }
    for (std::size_t level = 0; level < levels; ++level)
        whole.levels.push_back(sum_of(parts, level, levels));
    whole.best_level = int(levels) - 1;
    whole.cage = mesh::joined(cages);
    return whole;
}

}  // namespace patchwright::fit
