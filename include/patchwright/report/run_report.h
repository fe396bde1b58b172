// What one run did and measured, for people (HTML) and programs (JSON).
#pragma once

#include <patchwright/base/units.h>
#include <patchwright/fit/morph.h>
#include <patchwright/fit/refit.h>
#include <patchwright/grid/quality.h>
#include <patchwright/measure/deviation_statistics.h>
#include <patchwright/measure/fairness.h>
#include <patchwright/measure/field.h>
#include <patchwright/measure/relative_fairness.h>
#include <patchwright/measure/verdict.h>
#include <patchwright/mesh/cage.h>
#include <patchwright/mesh/polylines.h>
#include <patchwright/patch/continuity.h>
#include <patchwright/patch/extract.h>
#include <patchwright/report/family_figures.h>
#include <patchwright/report/model_figures.h>

#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::report {

struct FitFigures {
    std::vector<fit::WarpStage> carried;  ///< of a refit, before it
    double tolerance = 0.0;
    int best_level = 0;                ///< the one that was taken, from 0
    std::optional<int> symmetry_axis;  ///< of the symmetry plane that was kept: 0, 1 or 2
    /// See measure::distance_from_catmull_clark(); none: that rule is the cage's.
    std::optional<double> off_catmull_clark_mm;
    measure::Fairness before, after;
    std::vector<fit::FitLevel> levels;
};

struct PatchFigures {
    int count = 0, control_points = 0;
    std::string continuity;  ///< "g1" or "refined"
    std::string covering;    ///< "charts" or "faces"
    std::vector<patch::CapReport> caps;
};

struct DeviationFigures {
    measure::Deviation output_to_input, input_to_output;
    int sharp_curves_input = 0, sharp_curves_output = 0;
    /// Between the sharp feature curves; nothing when one side has none.
    std::optional<measure::Deviation> sharp_output_to_input, sharp_input_to_output;
    /// The input's sharp curves longer than 100 times the tolerance, and those of them that are
    /// farther than it from edges of the output; nothing when there is no tolerance.
    struct MissedCurve {
        double length = 0.0, distance = 0.0;
        geom::Vec3 at = geom::Vec3::Zero();
    };
    struct LongSharpCurves {
        double longer_than = 0.0, tolerance = 0.0;
        int count = 0;
        std::vector<MissedCurve> missed;
    };
    std::optional<LongSharpCurves> long_sharp;
    std::optional<measure::RelativeFairness> fairness;
};

/// A grid file.
struct GridFigures {
    std::string file;
    grid::GridQuality quality;
    /// Of grids that are refined cell by cell.
    struct Local {
        int levels = 0;  ///< times that the smallest cells were divided
        std::int64_t hanging_nodes = 0;
    };
    std::optional<Local> local = std::nullopt;
};

/// A cage carried along with points of a structural model; see fit::PointTransfer.
struct MorphFigures {
    int points = 0;              ///< of the model
    double extrapolation = 0.0;  ///< PointTransfer::extrapolation
    struct Step {
        std::string file;                                        ///< of displacements
        double largest_displacement = 0.0, largest_moved = 0.0;  ///< of these, of control points
        std::optional<measure::Verdict> verdict;  ///< here and below: of what was written
        std::optional<SolidFigures> solid;
        std::optional<GridFigures> grid;
    };
    std::vector<Step> steps;
    /// At places of the surface, and carried to the points, as written.
    struct Forces {
        int places = 0;
        fit::Resultant given;  ///< about the origin: the forces' unit, that times a length
        /// Of the carried ones' sum and moment, by sums of absolute values.
        double force_error = 0.0, moment_error = 0.0;
    };
    std::optional<Forces> forces;
};

/// What the page's 3-D view shows.
struct Scene {
    std::optional<measure::Field> output, input;
    std::optional<mesh::Cage> cage;  ///< that was fitted
    double scale_mm = 1.0;           ///< deviation that is the last colour; positive
};

/// A picture where there is no scene, of a mesh.
struct Drawing {
    std::string png, caption;
};

/// Why a run ended without a result.
struct Failure {
    int exit_code = 0;
    std::string message;
};

/// Sections that do not apply to a run stay empty and are left out of what is written.
struct RunReport {
    base::LengthUnit unit = base::LengthUnit::Millimetre;  ///< of all lengths as written
    /// The command and every option's value, given or by default, as on the command line.
    std::vector<std::pair<std::string, std::string>> options;
    std::optional<Failure> error;
    std::optional<measure::Verdict> verdict;  ///< first and last in the text
    std::optional<InputFigures> input;
    std::optional<mesh::CageSummary> cage;
    std::optional<mesh::PolylineSummary> polylines;
    /// Of a made cage, one line a body: what it was recognised as, or why it was remeshed.
    std::vector<std::string> layout;
    std::optional<FitFigures> fit;
    std::optional<MorphFigures> morph;
    std::optional<FamilyFigures> family;
    std::optional<PatchFigures> patches;
    std::optional<SolidFigures> solid;
    std::optional<DetailFigures> details;
    std::optional<DeviationFigures> deviation;
    std::optional<patch::Continuity> continuity;
    std::optional<GridFigures> grid;
    std::optional<Scene> scene;                           ///< not in the JSON
    std::optional<Drawing> drawing;                       ///< not in the JSON
    std::vector<std::pair<std::string, double>> seconds;  ///< stage, in order; "total" is added
    std::vector<std::string> notices;
    double peak_memory_mb = 0.0;
};

/// Changes when a key that programs read goes or changes its meaning, not when keys are added.
inline constexpr int schema_version = 1;

/// As src/report/report.schema.json says; lengths, areas and volumes in powers of report.unit.
std::string to_json(const RunReport& report);

/// One self-contained page.
std::string to_html(const RunReport& report);

enum class TextDetail {
    Brief,  ///< at most 15 lines
    Full
};

/// For the terminal: the verdict is the first and the last line.
std::string to_text(const RunReport& report, TextDetail detail = TextDetail::Full);

}  // namespace patchwright::report
#pragma GCC visibility pop
