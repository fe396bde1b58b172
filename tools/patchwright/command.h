// What all subcommands share: options, progress, reading and reporting.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/base/units.h>
#include <patchwright/fit/fit_parts.h>
#include <patchwright/geom/mesh_reference.h>
#include <patchwright/layout/bodies.h>
#include <patchwright/layout/make_cage.h>
#include <patchwright/mesh/cage.h>
#include <patchwright/occ/cad_reference.h>
#include <patchwright/report/run_report.h>

#include <CLI/CLI.hpp>

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace patchwright::cli {

/// The exit codes of the contract.
enum ExitCode {
    Done = 0,
    Usage = 1,
    BadInput = 2,
    ToleranceMissed = 3,
    NotWritten = 4,
    InternalError = 5
};

/// Options of every subcommand.
struct CommonOptions {
    bool quiet = false;
    bool verbose = false;
    bool progress = false;
    int threads = 0;
    std::string json;  ///< path, or "-" for standard output
    std::string html;
};

void add_common_options(CLI::App& command, CommonOptions& options, bool with_html);

/// Options of the subcommands that write a CAD file.
struct OutputOptions {
    std::string file;
    std::string unit = "input";
    std::string schema = "ap214";
    std::string continuity = "g1";
    std::string patches = "charts";
    int cap_depth = 0;  ///< 0: by the tolerance
    std::string colour = "none";
    bool time_stamp = false;
};

void add_output_options(CLI::App& command, OutputOptions& options);

/// Options of the subcommands that fit.
struct FitCommandOptions {
    std::string tolerance = "1e-4rel";
    std::string cage_unit = "mm";
    std::string refine = "local";
    std::string symmetry = "detect";
    int max_levels = 12;
    int max_vertices = 200000;  ///< of a fitted cage
    bool keeps_form = true;     ///< see fit::FitOptions
};

/// For a cage that was made: its form is no model for the fitted one's, and one that is no wing's
/// is made anew where it is too coarse, instead of being refined again and again.
FitCommandOptions for_made_cage(FitCommandOptions options, const layout::CageResult& made);

void add_fit_options(CLI::App& command, FitCommandOptions& options);

/// One run of a subcommand: its report, its clock and its talk to the user.
class Run {
  public:
    explicit Run(const CommonOptions& options);

    /// Draws the stage on standard error when asked to or on a terminal; stops on Ctrl-C.
    [[nodiscard]] base::Progress progress() const;

    /// Ends the stage that ran since the last call, or since the start, under this name; a stage
    /// that runs again adds up.
    void end_stage(const std::string& name);

    /// Remembered in the report, printed to standard error unless quiet.
    void notice(const std::string& text);

    /// Writes JSON and HTML where asked, prints the summary to standard output unless quiet.
    void finish();

    report::RunReport report;

  private:
    const CommonOptions& options_;
    std::chrono::steady_clock::time_point stage_start_;
};

/// A file as read: a CAD model, sewn, or triangles.
struct Input {
    std::optional<occ::CadModel> model;         ///< nothing for triangles
    std::unique_ptr<geom::MeshReference> mesh;  ///< nothing for CAD models
    std::unique_ptr<occ::CadReference> cad;     ///< see prepare
    double sharp_angle_deg = 0.0;               ///< as asked for
    report::SolidFigures figures;
    occ::ReadReport read;  ///< of CAD models
    geom::MeshRepair repair;

    /// @pre prepared
    [[nodiscard]] const geom::ModelSurface& reference() const {
        if (mesh) return *mesh;
        return *cad;
    }
};

struct InputOptions {
    std::string unit;              ///< overrides what the file says; empty: as it says
    bool heal = true;              ///< CAD models: sew and turn faces
    double sharp_angle_deg = 0.0;  ///< 0: as is usual for the kind of file
};

constexpr const char* input_help = "STEP, IGES, BREP, or triangles: STL, OBJ";

void add_input_options(CLI::App& command, InputOptions& options);

/// Reads a CAD file or triangles and fills report.input.
Input read_input(Run& run, const std::string& file, const InputOptions& options = {});

/// How references of the input are made.
occ::ReferenceOptions reference_options(const Run& run, const Input& input);

/// Makes the reference of a CAD model; triangles have theirs.
void prepare(Run& run, Input& input);

/// Says so where the tolerance is less than the triangles' own distance from what they stand for.
void note_chord_error(Run& run, const Input& input, double tolerance_mm);

/// What a model holds, as it is written into reports.
report::SolidFigures solid_figures(const std::string& file, const occ::CadModel& model);

/// Reads a cage whose numbers are in `unit`, in millimetres; fills report.cage.
mesh::Cage read_cage(Run& run, const std::string& file, base::LengthUnit unit);

/// How a cage is made where none is given.
struct LayoutOptions {
    std::string method = "auto";
    int target_faces = 0;   ///< 0: as curvature asks for
    double fineness = 1.0;  ///< of a further try: see layout::CageOptions
    std::vector<layout::CageOptions::Place> finer_at;
};

void add_layout_options(CLI::App& command, LayoutOptions& options);

/// Makes a cage from the input; fills report.cage.
/// @pre the input is prepared
layout::CageResult make_cage(Run& run, const Input& input, const LayoutOptions& options,
                             double tolerance_rel);

/// Writes a cage, atomically, in `unit`.
void write_cage(const mesh::Cage& cage, const std::string& file, base::LengthUnit unit);

/// A cage's limit surface as a model, with one point on each of its creases.
struct Assembled {
    occ::CadModel model;
    geom::Points crease_points;
};

/// Extracts patches and assembles them; fills report.patches.
/// @param tolerance_mm, source  see write_patches
Assembled assemble_patches(Run& run, const mesh::Cage& cage, const OutputOptions& options,
                           double tolerance_mm, const geom::ReferenceSurface* source = nullptr);

/// Looks at a model; fills report.solid, as of this file, and report.continuity.
void inspect_output(Run& run, const Assembled& output, const std::string& file);

/// Writes, reads back and looks at what was read; the model returned is the one on disk.
occ::CadModel write_assembled(Run& run, const Assembled& assembled, const OutputOptions& options,
                              base::LengthUnit unit);

/// Extracts patches, assembles, writes and reads back; fills report.patches, solid and continuity.
/// The model returned is the one on disk.
/// @param tolerance_mm  how far caps at extraordinary vertices may lie from the limit surface
/// @param source  the CAD that the cage was fitted to, if any: names and colours faces
occ::CadModel write_patches(Run& run, const mesh::Cage& cage, const OutputOptions& options,
                            base::LengthUnit unit, double tolerance_mm,
                            const geom::ReferenceSurface* source = nullptr);

/// Measures both ways and fills report.deviation.
/// @param tolerance_mm  with one, the input's sharp curves longer than 100 times it are looked at
///                      one by one
void compare_models(Run& run, const geom::ModelSurface& output, const geom::ModelSurface& input,
                    int samples, std::optional<double> tolerance_mm = std::nullopt,
                    bool with_bound = true);

/// Adds the bounds that compare_models left out.
void bound_deviation(Run& run, const geom::ModelSurface& output, const geom::ModelSurface& input);

/// What parts of made cages are fitted to, and what came of it so far.
struct PartFits {
    std::vector<layout::ModelBody> bodies;
    std::vector<fit::PartFit> known;
};

/// Nothing for triangles and for models that hang together.
/// @pre the input is prepared
std::optional<PartFits> part_fits(Run& run, const Input& input);

/// Fits and fills report.fit; the tolerance is for the final, two-sided deviation.
/// @param parts  with it, parts of the cage that do not hang together are fitted each to the body
///               of the model that it lies on, and results are kept for parts that come again
mesh::Cage fit_cage(Run& run, const mesh::Cage& cage, const geom::ModelSurface& reference,
                    const FitCommandOptions& options, PartFits* parts = nullptr);

/// The tolerance as a fraction of the reference's diagonal.
double relative_tolerance(const FitCommandOptions& options,
                          const geom::ReferenceSurface& reference);

/// Each registers its subcommand; `exit_code` receives what the run ends with.
void register_cage(CLI::App& app, int& exit_code);
void register_compare(CLI::App& app, int& exit_code);
void register_convert(CLI::App& app, int& exit_code);
void register_eval(CLI::App& app, int& exit_code);
void register_export(CLI::App& app, int& exit_code);
void register_fit(CLI::App& app, int& exit_code);
void register_grid(CLI::App& app, int& exit_code);
void register_inspect(CLI::App& app, int& exit_code);
void register_subdivide(CLI::App& app, int& exit_code);

}  // namespace patchwright::cli
