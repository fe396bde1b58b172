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
           k.keeps_form == o.keeps_form && k.max_levels == o.max_levels &&
           k.max_vertices == o.max_vertices && k.max_idle_levels == o.max_idle_levels &&
           k.refinement == o.refinement && k.symmetry == o.symmetry && is_same(known.given, part);
}

/// What part stands for level number `level` of `count`.
const FitLevel& level_of(const FitResult& part, std::size_t level, std::size_t count) {
    const std::size_t last = part.levels.size() - 1;
    return part.levels[level + 1 == count ? std::size_t(part.best_level) : std::min(level, last)];
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
        sum.max_mm = std::max(sum.max_mm, one.max_mm);
        sum.reverse_max_mm = std::max(sum.reverse_max_mm, one.reverse_max_mm);
        sum.curve_max_mm = std::max(sum.curve_max_mm, one.curve_max_mm);
        sum.chains_on_features += one.chains_on_features;
        if (level >= part.result.levels.size()) continue;
        const FitLevel& worked = part.result.levels[level];
        sum.projections += worked.projections;
        sum.cgls_steps += worked.cgls_steps;
        sum.solves_by_length += worked.solves_by_length;
        sum.solves_by_steps += worked.solves_by_steps;
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

}  // namespace

PartsFit fit_parts(const std::vector<mesh::Cage>& parts,
                   const std::vector<const geom::ReferenceSurface*>& references,
                   const FitOptions& options, const std::vector<PartFit>& known) {
    if (parts.size() != references.size() || parts.empty())
        throw base::InvalidArgument(
            fmt::format("{} references for {} parts", references.size(), parts.size()));
    constexpr int least_samples = 1000;
    int vertices = 0;
    for (const mesh::Cage& part : parts) vertices += part.topology->vertex_count();
    PartsFit result;
    std::vector<mesh::Cage> fitted;
    std::size_t levels = 0;
    result.whole.met = true;
    for (const auto& [part, reference] : by_reference(parts, references)) {
        FitOptions of_part = options;
        const double share = double(part.topology->vertex_count()) / vertices;
        of_part.max_vertices = int(std::lround(share * options.max_vertices));
        of_part.reverse_samples =
            std::min(options.reverse_samples,
                     std::max(least_samples, int(std::lround(share * options.reverse_samples))));
        const auto same = std::find_if(known.begin(), known.end(), [&](const PartFit& k) {
            return is_same(k, part, reference, of_part);
        });
        result.parts.push_back(
            {part, reference, of_part,
             same != known.end() ? same->result : fit(part, *reference, of_part)});
        const FitResult& one = result.parts.back().result;
        fitted.push_back(one.cage);
        levels = std::max(levels, one.levels.size());
        result.whole.met = result.whole.met && one.met;
        result.whole.faces_away = result.whole.faces_away || one.faces_away;
        const int axis = one.symmetry_axis;
        result.whole.symmetry_axis =
            result.parts.size() == 1 || axis == result.whole.symmetry_axis ? axis : -1;
    }
    for (std::size_t level = 0; level < levels; ++level)
        result.whole.levels.push_back(sum_of(result.parts, level, levels));
    result.whole.best_level = int(levels) - 1;
    result.whole.cage = mesh::joined(fitted);
    return result;
}

}  // namespace patchwright::fit
