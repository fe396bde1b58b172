// Converts a model to a few smooth patches that form one solid, and says how good they are.
#pragma once

#include <patchwright/base/budget.h>
#include <patchwright/base/output_set.h>
#include <patchwright/cage/make_cage.h>
#include <patchwright/convert/shape.h>
#include <patchwright/convert/source.h>
#include <patchwright/fit/refit.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::convert {

struct ConvertOptions {
    double tolerance_mm = 0.1;  ///< of the two-sided deviation of the written file
    /// Of its normals beyond the input's edges, see measure::RelativeFairness; none: no limit.
    std::optional<double> normal_tolerance_rad;
    /// The cage to be fitted; none: cages are made from the model.
    std::optional<mesh::Cage> cage;
    cage::Method method = cage::Method::Auto;  ///< of made cages
    std::optional<int> target_faces;           ///< of made cages, about
    /// Of cages whose quads lie in strips; remeshed ones are always refined globally.
    fit::RefinementScope refinement = fit::RefinementScope::Local;
    fit::Symmetry symmetry = fit::Symmetry::Detect;
    std::optional<mesh::CreaseRule> crease_rule;  ///< see fit::FitOptions; refits keep the cage's
    std::optional<int> max_levels;  ///< of the fit; none: as the kind of cage asks for
    bool interpolate = false;       ///< see fit::FitOptions
    /// The cage was fitted to an earlier state of the model: it is carried over to this one and
    /// keeps its topology, see fit::refit.
    bool refit = false;
    /// Of a refit: what the cage was fitted to, with the same faces as the model has; not owned,
    /// null: not known.
    const Source* earlier = nullptr;
    ShapeOptions shape;
    int samples = 20000;  ///< of the check, each way
};

/// What a made cage is like.
enum class CageKind {
    Given,     ///< by the user
    Sections,  ///< along the lines of recognised wings, blades and bodies around an axis
    Field,     ///< four-sided blocks between the lines of a cross field, some at least
    Blocks,    ///< four-sided blocks along faces
    Remeshed   ///< even triangles paired to quads
};

/// What an attempt does. Two plans whose cages are the same share the cage.
struct AttemptPlan {
    cage::CageOptions cage;  ///< of a made one
    bool given = false;      ///< the user's cage in place of a made one
    /// Keep the form of the cage's lines; see fit::FitOptions.
    bool preserve_parametrisation = true;
    double fit_share = 1.0;  ///< of the tolerance: what the fit aims at

    [[nodiscard]] bool same_cage(const AttemptPlan& other) const;
};

/// One cage, fitted, and what came of it.
struct Attempt {
    AttemptPlan plan;
    CageKind kind = CageKind::Given;
    mesh::Cage cage;                  ///< before the fit
    std::vector<std::string> layout;  ///< one line a body: what it was recognised as
    mesh::Cage fitted;
    bool stopped_by_time_limit = false;  ///< its fit
    bool keeps_cage = false;             ///< as refits do
    bool finer_refused = false;          ///< there is no finer cage of its kind
    bool faces_refused = false;          ///< there are no blocks along faces
    report::FitFigures fit;
    std::vector<geom::Vec3> misses;  ///< of the fit, see fit::FitResult
    report::PatchFigures patches;
    ShapeFigures shape;
    report::DeviationFigures deviation;
    measure::FoldFigures folds;
    measure::Verdict verdict;
    /// Patches, shape, deviation and folds are known; else they are empty but for folds, which are
    /// looked for where the fit meets, and the verdict is on these and the fit's own samples.
    bool measured = false;
    /// The file beside its final name, read back and measured; dropped when another one is better.
    std::shared_ptr<base::PendingFile> file;
    std::shared_ptr<const occ::CadReference> output;  ///< what was measured; dropped with the file

    void drop_file() {
        file.reset();
        output.reset();
    }
};

struct Conversion {
    std::vector<Attempt> attempts;    ///< in order
    std::optional<std::size_t> kept;  ///< the best one; none when the time limit came first
    /// Of a model of several bodies whose cages are made: the attempts on each body by itself, of
    /// which the best together are an attempt on the model; they have no files, and where bodies
    /// are apart and the first ones together meet, are not measured.
    std::vector<Conversion> bodies;
    bool time_limit_reached = false;
    std::vector<std::pair<std::string, double>> seconds;  ///< stage, in order
    std::vector<std::string> notices;                     ///< one line each, for the user
};

/// The verdict on an attempt, from its figures and the source's.
measure::Verdict assess(const Attempt& attempt, const Source& source, double tolerance_mm,
                        std::optional<double> normal_tolerance_rad = std::nullopt);

/// What to try next: nothing once an attempt is met, with a given cage unless only normals miss, or
/// when nothing that is left to try can be expected to be better.
std::optional<AttemptPlan> choose_next(const std::vector<Attempt>& attempts,
                                       const ConvertOptions& options, double diagonal_mm);

/// The best attempt, or the best one of those that are measured; the first of equal ones.
std::optional<std::size_t> choose_best(const std::vector<Attempt>& attempts,
                                       bool only_measured = false);

/// Makes attempts until one is met, none is left, or the budget or memory is used up, and adds the
/// best one to `outputs`, as the file `output`. A body is converted as it would be alone: further
/// attempts are made of those that miss. Missing the tolerance is a verdict, not an error.
/// Where the budget is not used up, the bytes written do not depend on time or on the number of
/// threads.
/// @throw InputError when no cage can be made, or the one to be fitted again is of no earlier state
///        of the model: it has another size, or borders where the model has none or the reverse
/// @throw OutputError when `output` cannot be written
/// @throw Cancelled when the budget's callback says so
/// @throw std::bad_alloc when memory is used up before there is a result
Conversion convert(const Source& source, const std::filesystem::path& output,
                   base::OutputSet& outputs, const ConvertOptions& options,
                   const base::Budget& budget = base::Budget());

/// The same with `output` put in its place; an older file stays as it was when this fails.
Conversion convert(const Source& source, const std::filesystem::path& output,
                   const ConvertOptions& options, const base::Budget& budget = base::Budget());

/// One cage, given or made, and fitted: the only attempt, without a shape or a file. Its verdict is
/// on the distances that the fit's own samples see, with a limit for normals on these, of refits
/// also on the folds of its patches.
/// @throw TimeLimitReached when no level of the fit was completed, else as convert()
Conversion fit_only(const Source& source, const ConvertOptions& options,
                    const base::Budget& budget = base::Budget());

}  // namespace patchwright::convert
#pragma GCC visibility pop
