// CAD models: an opaque handle to a kernel shape, and the files it comes from and goes to.
#pragma once

#include <patchwright/base/colour.h>
#include <patchwright/base/output_set.h>
#include <patchwright/base/progress.h>
#include <patchwright/base/units.h>
#include <patchwright/geom/types.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::occ {

enum class FileFormat { Step, Iges, Brep };

/// By extension: .step .stp, .igs .iges, .brep .brp (any case).
/// @throw InputError when the extension is none of these
FileFormat file_format(const std::filesystem::path& path);

/// A shape of the CAD kernel in millimetres, with where it came from. Cheap to copy; immutable.
class CadModel {
  public:
    struct Impl;  ///< defined in src/occ only
    explicit CadModel(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
    [[nodiscard]] const Impl& impl() const { return *impl_; }

  private:
    std::shared_ptr<const Impl> impl_;
};

using base::Colour;

/// One a face in the order of all face numbers of this room; empty strings and colours where a file
/// gives none.
std::vector<std::string> face_names(const CadModel& model);
std::vector<std::optional<Colour>> face_colours(const CadModel& model);

/// The same model with other names of faces.
/// @throw InvalidArgument when there is not one entry a face
CadModel with_face_names(const CadModel& model, std::vector<std::string> names);

/// The same model with other colours, for writing.
/// @throw InvalidArgument when there is not one entry a face
CadModel with_face_colours(const CadModel& model, std::vector<std::optional<Colour>> colours);

/// Faces that hang together by common edges, as numbers; parts in the order of their first faces.
std::vector<std::vector<int>> connected_faces(const CadModel& model);

/// Some faces of a model by themselves, in this order, with their names and colours; solids and
/// shells are gone.
/// @throw InvalidArgument when a number is none of a face
CadModel part_of(const CadModel& model, const std::vector<int>& faces);

/// An entity of a file that should have given faces and gave none.
struct LostEntity {
    std::string entity;  ///< as the file numbers it: "#17" in STEP, directory entry "D17" in IGES
    std::string type;    ///< "ADVANCED_FACE", "144 trimmed surface"
    std::optional<std::string> reason;
};

/// Smallest and largest distance from a free edge to the next one.
struct OpenGaps {
    double smallest_mm = 0.0, largest_mm = 0.0;
};

/// How loose faces were joined.
struct SewnGaps {
    double largest_mm = 0.0;    ///< that was closed
    double tolerance_mm = 0.0;  ///< that it took
};

/// What reading changed or noticed.
struct ReadReport {
    FileFormat format = FileFormat::Step;
    std::string schema;              ///< "AP214", "IGES 5.3", ...; may be empty
    std::string originating_system;  ///< as the file says; may be empty
    base::LengthUnit unit = base::LengthUnit::Millimetre;  ///< of the file, or the override
    int faces_in_file = 0;                                 ///< that could be transferred
    std::vector<LostEntity> lost;                          ///< what could not; STEP and IGES only
    int free_edges_before = 0;                             ///< edges used by one face only, as read
    int free_edges_after = 0;                              ///< after sewing
    std::optional<SewnGaps> sewn;                          ///< empty: nothing was
    std::optional<OpenGaps> open_gaps;                     ///< after sewing; empty: nothing is open
    int duplicates_dropped = 0;                            ///< loose faces that lie on another
    int slivers_dropped = 0;                               ///< loose faces without width
    int faces_turned = 0;              ///< by making orientations agree and look outward
    int edges_rejoined = 0;            ///< pairs in one place whose faces had been joined crosswise
    int pcurves_projected = 0;         ///< that left their edges between the places of checks
    int pcurves_replaced = 0;          ///< that ran out of step with their edges after sewing
    std::vector<std::string> notices;  ///< one line each, for the user
};

struct ReadOptions {
    std::optional<base::LengthUnit> unit;  ///< overrides what the file says; BREP: none is mm
    bool allow_loss = false;  ///< entities that give no faces are in the report, not an error
    bool heal = true;         ///< sew loose faces, orient shells; false: as is
    /// STEP: without the repairs that the kernel makes of its own, for what has been written here.
    bool as_written = false;
    /// Upper bound for the sewing tolerance as a fraction of the diagonal. Above 1e-4 gaps are
    /// closed only if nothing stays open then.
    double max_sewing_tolerance_rel = 1e-3;
    base::Progress progress;
};

struct ReadResult {
    CadModel model;
    ReadReport report;
};

/// Reads STEP (AP203, AP214, AP242), IGES 5.x or BREP, with names and colours of faces. Closed
/// shells become solids, outward oriented.
/// @throw InputError when the file is missing, not of its format, truncated, names no known unit,
///        or holds no faces or some that the kernel cannot transfer
/// @throw Cancelled or TimeLimitReached from the progress callback
ReadResult read_cad(const std::filesystem::path& path, const ReadOptions& options = {});

enum class StepSchema { Ap203, Ap214, Ap242 };

struct WriteOptions {
    base::LengthUnit unit = base::LengthUnit::Millimetre;
    StepSchema schema = StepSchema::Ap214;
    std::optional<std::string> name;  ///< of the model inside the file; none: the file's
    bool time_stamp = false;  ///< the clock's time instead of a fixed one, in formats that have one
};

/// Writes the format of the extension; two calls with one model give identical bytes, unless a time
/// stamp is asked for. STEP holds names and colours of faces, with AP242 also area, volume and
/// centroid as validation properties; IGES colours and names of eight characters.
/// @throw OutputError when the kernel or the file system refuses
void write_cad(const CadModel& model, base::PendingFile& file, const WriteOptions& options = {});

/// The same to its place; an older file stays as it was when this fails.
void write_cad(const CadModel& model, const std::filesystem::path& path,
               const WriteOptions& options = {});

}  // namespace patchwright::occ
#pragma GCC visibility pop
