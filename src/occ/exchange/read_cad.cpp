#include "occ/exchange/cad_model_impl.h"
#include "occ/exchange/exchange_session.h"
#include "occ/exchange/face_attributes.h"
#include "occ/exchange/file_checks.h"
#include "occ/exchange/file_unit.h"
#include "occ/exchange/iges_repair.h"
#include "occ/exchange/lost_entities.h"
#include "occ/exchange/memory_file.h"
#include "occ/exchange/shape_checks.h"
#include "occ/foot/tight_bounds.h"
#include "occ/heal/heal.h"
#include "occ/kernel_guard.h"
#include "occ/kernel_progress.h"

#include <patchwright/base/error.h>

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <STEPControl_Reader.hxx>
#include <StepData_StepModel.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace patchwright::occ {

namespace {

using Path = std::filesystem::path;

std::string text_of(const Handle(TCollection_HAsciiString) & text) {
    std::string result = text.IsNull() ? "" : text->ToCString();
    result.erase(0, std::min(result.find_first_not_of(' '), result.size()));
    return result;
}

/// What comes of a file before anything is done to it.
struct Transfer {
    TopoDS_Shape shape;
    FaceAttributeMap attributes;
    double unit_mm = 1.0;  ///< what the kernel has taken the file's lengths times
};

constexpr std::array units{base::LengthUnit::Millimetre, base::LengthUnit::Centimetre,
                           base::LengthUnit::Metre, base::LengthUnit::Inch, base::LengthUnit::Foot};

/// Relative: the same unit by other conversion factors. The US survey foot differs by 2e-6.
constexpr double same_unit = 1e-9;

/// @throw InputError when nobody says what the unit is
void settle_unit(const Path& path, const FileUnit& unit, const ReadOptions& options,
                 ReadReport& report) {
    if (unit.problem && !options.unit) refuse(path, "{}; pass --input-unit", *unit.problem);
    if (unit.problem) {
        report.unit = *options.unit;
        report.notices.push_back(fmt::format("{}: {}; read as {}", path.string(), *unit.problem,
                                             base::short_name(*options.unit)));
        return;
    }
    if (unit.differs)
        report.notices.push_back(
            fmt::format("{}: parts are in different units; reports use the first", path.string()));
    for (const base::LengthUnit known : units) {
        const double millimetres = base::millimetres_per(known);
        if (std::abs(unit.millimetres - millimetres) > same_unit * millimetres) continue;
        report.unit = known;
        return;
    }
    report.notices.push_back(
        fmt::format("{}: the unit of {:g} mm has no short name here; lengths are right, reports "
                    "use mm",
                    path.string(), unit.millimetres));
}

std::string step_schema_name(const std::string& identifier) {
    const auto has = [&](const char* part) { return identifier.find(part) != std::string::npos; };
    if (has("AP242")) return "AP242";
    if (has("AUTOMOTIVE_DESIGN")) return "AP214";
    if (has("CONFIG_CONTROL_DESIGN") || has("AP203")) return "AP203";
    return identifier.substr(0, identifier.find(' '));
}

/// @throw Cancelled when the callback stops it
void transfer_roots(XSControl_Reader& reader, const base::Progress& progress) {
    const Handle(KernelProgress) polled = new KernelProgress(progress, "read", 0.1);
    reader.TransferRoots(polled->Start());
    polled->check();
}

Transfer read_step(const Path& path, const ReadOptions& options, ReadReport& report) {
    const std::string text = check_step_file(path);
    ExchangeSession session;
    if (options.as_written) session.leave_shapes();
    STEPControl_Reader reader;
    if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) {
        refuse(path, "is not readable as STEP; the CAD kernel finds errors of syntax");
    }
    APIHeaderSection_MakeHeader header(reader.StepModel());
    report.originating_system = text_of(header.OriginatingSystem());
    if (report.originating_system.empty()) {
        report.originating_system = text_of(header.PreprocessorVersion());
    }
    if (header.NbSchemaIdentifiers() > 0) {
        report.schema = step_schema_name(text_of(header.SchemaIdentifiersValue(1)));
    }
    const FileUnit unit = step_unit(reader.StepModel(), text);
    settle_unit(path, unit, options, report);
    transfer_roots(reader, options.progress);
    Transfer result{reader.OneShape(), step_attributes(reader), unit.millimetres};
    report.lost = lost_in_step(reader, result.shape, text);
    return result;
}

Transfer read_iges(const Path& path, const ReadOptions& options, ReadReport& report) {
    const std::string text = check_iges_file(path);
    const auto repair = repair_iges(text);
    std::optional<MemoryFile> repaired;
    if (repair) {
        repaired.emplace(repair->text);
        for (const std::string& notice : repair->notices)
            report.notices.push_back(fmt::format("{}: {}", path.string(), notice));
    }
    ExchangeSession session;
    IGESControl_Reader reader;
    if (reader.ReadFile(repaired ? repaired->path().c_str() : path.c_str()) != IFSelect_RetDone) {
        refuse(path, "is not readable as IGES; the CAD kernel finds errors of syntax");
    }
    const IGESData_GlobalSection global = reader.IGESModel()->GlobalSection();
    report.originating_system = text_of(global.SystemId());
    constexpr std::array versions{"",         "IGES 1.0",  "ANSI 1981", "IGES 2.0",
                                  "IGES 3.0", "ASME 1987", "IGES 4.0",  "ASME 1989",
                                  "IGES 5.0", "IGES 5.1",  "IGES 5.2",  "IGES 5.3"};
    const int version = global.IGESVersion();
    if (version > 0 && version < static_cast<int>(versions.size())) {
        report.schema = versions[std::size_t(version)];
    }
    const FileUnit unit = iges_unit(reader.IGESModel(), text);
    settle_unit(path, unit, options, report);
    transfer_roots(reader, options.progress);
    Transfer result{reader.OneShape(), iges_attributes(reader), unit.millimetres};
    report.lost = lost_in_iges(reader, result.shape);
    return result;
}

/// The format has no unit: the kernel's is the millimetre.
Transfer read_brep(const Path& path, const ReadOptions& options, ReadReport& report) {
    check_brep_file(path);
    settle_unit(path, {}, options, report);
    // This reader prints on std::cout what it does not like.
    const ExchangeSession session;
    Transfer result;
    if (!BRepTools::Read(result.shape, path.c_str(), BRep_Builder())) {
        refuse(path, "is not readable as BREP; get a complete copy");
    }
    return result;
}

Transfer transfer(const Path& path, const ReadOptions& options, ReadReport& report) {
    switch (report.format) {
        case FileFormat::Step: return read_step(path, options, report);
        case FileFormat::Iges: return read_iges(path, options, report);
        case FileFormat::Brep: break;
    }
    return read_brep(path, options, report);
}

int face_count(const TopoDS_Shape& shape) {
    TopTools_IndexedMapOfShape map;
    if (!shape.IsNull()) TopExp::MapShapes(shape, TopAbs_FACE, map);
    return map.Extent();
}

/// Refuses a file that is not read whole, or says what is missing.
/// @throw InputError unless options.allow_loss
void settle_losses(const Path& path, const ReadOptions& options, ReadReport& report) {
    constexpr std::size_t most_named = 5;  // in one line
    std::string all;
    for (std::size_t i = 0; i < report.lost.size(); ++i) {
        const LostEntity& lost = report.lost[i];
        const std::string text = fmt::format("{} {}{}{}", lost.entity, lost.type,
                                             lost.reason ? ": " : "", lost.reason.value_or(""));
        if (i < most_named) all += (i == 0 ? "" : "; ") + text;
        if (options.allow_loss)
            report.notices.push_back(fmt::format("{}: {} is lost", path.string(), text));
    }
    if (report.lost.empty() || options.allow_loss) return;
    if (report.lost.size() > most_named)
        all += fmt::format("; and {} more", report.lost.size() - most_named);
    refuse(
        path,
        "{} faces can be transferred, but not {}; repair the file, or pass --allow-loss to go on "
        "without them",
        report.faces_in_file, all);
}

void apply_unit_override(Transfer& transfer, const ReadOptions& options, ReadReport& report,
                         FaceOrigins& origins) {
    if (!options.unit) return;
    const double factor = base::millimetres_per(*options.unit) / transfer.unit_mm;
    if (std::abs(factor - 1.0) > same_unit) {
        gp_Trsf scale;
        scale.SetScaleFactor(factor);
        BRepBuilderAPI_Transform scaled(transfer.shape, scale, true);
        for (TopExp_Explorer it(transfer.shape, TopAbs_FACE); it.More(); it.Next())
            origins.replaced(it.Current(), scaled.ModifiedShape(it.Current()));
        transfer.shape = scaled.Shape();
    }
    if (*options.unit == report.unit) return;
    report.notices.push_back(fmt::format("unit {} of the file is overridden by {}",
                                         base::short_name(report.unit),
                                         base::short_name(*options.unit)));
    report.unit = *options.unit;
}

}  // namespace

ReadResult read_cad(const Path& path, const ReadOptions& options) {
    base::report_progress(options.progress, "read", 0.0);
    ReadReport report;
    report.format = file_format(path);
    auto impl = std::make_shared<CadModel::Impl>();
    guard_kernel<base::InputError>(path.string(), [&] {
        Transfer read = transfer(path, options, report);
        report.faces_in_file = face_count(read.shape);
        settle_losses(path, options, report);
        if (report.faces_in_file == 0) {
            refuse(path,
                   "holds no faces that the CAD kernel can transfer; export it anew with surfaces");
        }
        if (const auto missing = missing_geometry(read.shape))
            refuse(path, "{}; repair the file", *missing);
        base::report_progress(options.progress, "read", 0.5);
        FaceOrigins origins;
        apply_unit_override(read, options, report, origins);
        const TopoDS_Shape shape = keep_faces(read.shape);
        const double size = tight_bounds(shape).diagonal();
        if (!std::isfinite(size))
            refuse(path, "the model reaches beyond what numbers hold; repair its coordinates");
        report.free_edges_before = count_free_edges(shape);
        impl->shape = options.heal ? heal(shape, size, options.max_sewing_tolerance_rel, report,
                                          origins, options.progress)
                                   : shape;
        report.free_edges_after = count_free_edges(impl->shape);
        for (const TopoDS_Face& face : faces_of(CadModel(impl))) {
            const FaceAttributes& given = read.attributes[origins.origin(face)];
            impl->face_names.push_back(given.name);
            impl->face_colours.push_back(given.colour);
        }
    });
    base::report_progress(options.progress, "read", 1.0);
    return {CadModel(std::move(impl)), std::move(report)};
}

}  // namespace patchwright::occ
