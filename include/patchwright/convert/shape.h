// The limit surface of a cage as a CAD model: made, written, read back, measured.
#pragma once

#include <patchwright/geom/model_surface.h>
#include <patchwright/measure/folds.h>
#include <patchwright/measure/self_intersection.h>
#include <patchwright/measure/verdict.h>
#include <patchwright/occ/cad_model.h>
#include <patchwright/patch/extract.h>
#include <patchwright/report/run_report.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::convert {

/// Colours of the faces that are written.
enum class Colouring {
    None,
    Kind,      ///< blue: regular, orange: with an extraordinary corner
    Deviation  ///< from the input: blue 0, red the tolerance or more
};

struct ShapeOptions {
    patch::Join join = patch::Join::G1;
    patch::Covering covering = patch::Covering::Charts;
    std::optional<int> cap_depth;  ///< none: as the tolerance asks for
    Colouring colouring = Colouring::None;
    occ::WriteOptions write;
};

/// How near the patches have to come.
struct ShapeTolerance {
    /// Of caps at extraordinary vertices from the limit surface; empty: patch::ExtractOptions.
    std::optional<double> caps_mm;
    double whole_mm = 0.0;  ///< of the whole conversion
};

/// Patches and the model assembled from them.
struct Shape {
    occ::CadModel model;
    report::PatchFigures patches;
    std::vector<geom::BsplineSurface> surfaces;  ///< one a patch
    std::vector<int> bodies;  ///< of each patch; patches that hang together have the same number
    std::vector<geom::BsplineCurve> creases;
    geom::Points crease_points;        ///< one on each crease edge
    geom::Points singular_points;      ///< vertices without a tangent plane
    bool closed = false;               ///< the cage has no boundary edges
    double tolerance_mm = 0.0;         ///< ShapeTolerance::whole_mm
    std::vector<std::string> notices;  ///< one line each, for the user
};

/// @param source  what the cage was fitted to: names faces and colours them by deviation
/// @throw InvalidArgument when colours by deviation are asked for without a source
Shape make_shape(const mesh::Cage& cage, const ShapeOptions& options, ShapeTolerance tolerance,
                 const geom::ReferenceSurface* source = nullptr);

/// Writes the shape's model and reads it back.
/// @throw OutputError when it cannot be written, or not be read back
occ::CadModel write_and_read_back(const Shape& shape, base::PendingFile& file,
                                  const occ::WriteOptions& options);

/// What is measured on a model without its input.
struct ShapeFigures {
    report::SolidFigures solid;
    patch::Continuity continuity;
    std::vector<measure::SelfIntersection> self_intersections;  ///< within bodies
    /// Between bodies, which may cross on purpose: a fault where the bodies of an input do not.
    std::vector<measure::SelfIntersection> crossing_bodies;
    int bodies = 0;  ///< faces that hang together
};

/// @param model  the shape's, or the same as read back from `file`
ShapeFigures inspect_shape(const Shape& shape, const occ::CadModel& model, const std::string& file,
                           const base::Progress& progress = {});

/// What to tell the user of bodies that cross where there is no input to compare with, if any do.
std::optional<std::string> crossing_notice(const ShapeFigures& figures);

/// The figures of a verdict that a shape has by itself. Bodies are told, but are no condition.
/// @param closed  whether it has to be
measure::VerdictFigures verdict_figures(const ShapeFigures& figures, bool closed);

/// Both ways, normals and curvatures, sharp curves one by one where there is a tolerance; without
/// bounds.
report::DeviationFigures compare(const geom::ModelSurface& output, const geom::ModelSurface& input,
                                 int samples, std::optional<double> tolerance_mm,
                                 const base::Progress& progress = {});

/// Adds the bounds for all points between the samples.
void add_bounds(report::DeviationFigures& deviation, const geom::ModelSurface& output,
                const geom::ModelSurface& input, const base::Progress& progress = {});

/// Adds distances and sharp curves to a verdict's figures.
void add_deviation(measure::VerdictFigures& figures, const report::DeviationFigures& deviation);

/// Adds the largest angle between normals, where some were measured.
void add_normals(measure::VerdictFigures& figures, const measure::RelativeFairness& fairness);

/// Raises distances to what a fit's samples and its creases have seen.
void add_fit(measure::VerdictFigures& figures, const report::FitFigures& fit);

/// What was looked for and found.
void add_folds(measure::VerdictFigures& figures, const measure::FoldFigures& folds);

}  // namespace patchwright::convert
#pragma GCC visibility pop
