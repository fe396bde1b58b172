#include "fit/loop/given.h"

#include <patchwright/base/error.h>
#include <patchwright/fit/fit_parts.h>
#include <patchwright/mesh/obj.h>
#include <patchwright/mesh/parts.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace patchwright::fit {

namespace {

bool is_same(const mesh::Cage& a, const mesh::Cage& b) {
    return a.topology == b.topology ||
           (a.points.rows() == b.points.rows() && a.points == b.points &&
            mesh::obj_text(a) == mesh::obj_text(b));
}

bool is_same(const PartFit& known, const mesh::Cage& part, const geom::ReferenceSurface* reference,
             const FitOptions& o) {
    const FitOptions& k = known.options;
    return known.reference == reference && k.tolerance_mm == o.tolerance_mm &&
           k.preserve_parametrisation == o.preserve_parametrisation &&
           k.max_levels == o.max_levels && k.max_vertices == o.max_vertices &&
           k.max_idle_levels == o.max_idle_levels && k.refinement == o.refinement &&
           k.symmetry == o.symmetry && k.interpolate == o.interpolate && is_same(known.given, part);
}

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

FitLevel sum_of(const std::vector<PartFit>& parts, std::size_t level, std::size_t count) {
    FitLevel sum;
    double squares = 0.0;
    for (const PartFit& part : parts) {
        const FitLevel& one = level_of(part.result, level, count);
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
        if (level >= part.result.levels.size()) continue;
        const FitLevel& worked = part.result.levels[level];
        sum.projections += worked.projections;
        sum.cgls_steps += worked.cgls_steps;
        sum.solves_by_step_tolerance += worked.solves_by_step_tolerance;
        sum.solves_by_max_iterations += worked.solves_by_max_iterations;
        sum.seconds += worked.seconds;
    }
    sum.rms_mm = sum.samples > 0 ? std::sqrt(squares / double(sum.samples)) : 0.0;
    return sum;
}

/// Parts of the same surface as one, in the order of their first ones.
std::vector<std::pair<mesh::Cage, const geom::ReferenceSurface*>> by_reference(
    const std::vector<mesh::Cage>& parts,
    const std::vector<const geom::ReferenceSurface*>& references) {
    std::vector<std::pair<mesh::Cage, const geom::ReferenceSurface*>> result;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (std::find(references.begin(), references.begin() + std::ptrdiff_t(i), references[i]) !=
            references.begin() + std::ptrdiff_t(i))
            continue;
        std::vector<mesh::Cage> same;
        for (std::size_t k = i; k < parts.size(); ++k)
            if (references[k] == references[i]) same.push_back(parts[k]);
        result.emplace_back(same.size() == 1 ? same.front() : mesh::joined(same), references[i]);
    }
    return result;
}

/// Nothing where the time limit is reached before there is a level.
std::optional<FitResult> fit_in_time(const mesh::Cage& part,
                                     const geom::ReferenceSurface& reference,
                                     const FitOptions& options) {
    try {
        return fit(part, reference, options);
    } catch (const base::TimeLimitReached&) {
        return std::nullopt;
    }
}

FitOptions options_of_part(FitOptions options, double share) {
    constexpr int min_samples = 1000;
    options.max_vertices = int(std::lround(share * options.max_vertices));
    options.reverse_samples =
        std::min(options.reverse_samples,
                 std::max(min_samples, int(std::lround(share * options.reverse_samples))));
    return options;
}

FitResult whole_of(const std::vector<PartFit>& parts) {
    FitResult whole{.within_tolerance = true, .symmetry_axis = parts.front().result.symmetry_axis};
    std::vector<mesh::Cage> cages;
    std::size_t levels = 0;
    for (const PartFit& part : parts) {
        const FitResult& one = part.result;
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

}  // namespace

PartsFit fit_parts(const std::vector<mesh::Cage>& parts,
                   const std::vector<const geom::ReferenceSurface*>& references,
                   const FitOptions& options, const std::vector<PartFit>& known) {
    if (parts.size() != references.size() || parts.empty())
        throw base::InvalidArgument(
            fmt::format("{} references for {} parts", references.size(), parts.size()));
    int vertices = 0;
    for (const mesh::Cage& part : parts) vertices += part.topology->vertex_count();
    PartsFit result;
    bool stopped = false;
    for (const auto& [part, reference] : by_reference(parts, references)) {
        const FitOptions of_part =
            options_of_part(options, double(part.topology->vertex_count()) / vertices);
        const auto same = std::find_if(known.begin(), known.end(), [&](const PartFit& k) {
            return is_same(k, part, reference, of_part);
        });
        std::optional<FitResult> one;
        if (same != known.end())
            one = same->result;
        else if (!stopped)
            one = fit_in_time(part, *reference, of_part);
        if (!one) {
            if (result.parts.empty()) throw base::TimeLimitReached();
            one = measure_given(part, *reference, of_part);
            one->stopped_by_time_limit = true;
        }
        stopped = stopped || one->stopped_by_time_limit;
        result.parts.push_back({part, reference, of_part, *std::move(one)});
    }
    result.whole = whole_of(result.parts);
    return result;
}

}  // namespace patchwright::fit
