#include "occ/exchange/cad_model_impl.h"
#include "occ/exchange/exchange_session.h"
#include "occ/exchange/face_attributes.h"
#include "occ/exchange/file_checks.h"
#include "occ/exchange/iges_repair.h"
#include "occ/exchange/lost_entities.h"
#include "occ/exchange/temporary_file.h"
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
#include <Interface_EntityIterator.hxx>
#include <STEPControl_Reader.hxx>
#include <StepData_StepModel.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace patchwright::occ {

namespace {

using Path = std::filesystem::path;

std::string text_of(const Handle(TCollection_HAsciiString) & text) {
    std::string result = text.IsNull() ? "" : text->ToCString();
    result.erase(0, std::min(result.find_first_not_of(' '), result.size()));
    return result;
}

std::optional<base::LengthUnit> unit_by_name(std::string name) {
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    using base::LengthUnit;
    constexpr std::array<std::pair<const char*, LengthUnit>, 15> names{{
        {"MILLIMETRE", LengthUnit::Millimetre},
        {"MILLIMETER", LengthUnit::Millimetre},
        {"MM", LengthUnit::Millimetre},
        {"CENTIMETRE", LengthUnit::Centimetre},
        {"CENTIMETER", LengthUnit::Centimetre},
        {"CM", LengthUnit::Centimetre},
        {"METRE", LengthUnit::Metre},
        {"METER", LengthUnit::Metre},
        {"M", LengthUnit::Metre},
        {"INCH", LengthUnit::Inch},
        {"IN", LengthUnit::Inch},
        {"FOOT", LengthUnit::Foot},
        {"FEET", LengthUnit::Foot},
        {"FT", LengthUnit::Foot},
        {"INCHES", LengthUnit::Inch},
    }};
    for (const auto& [known, unit] : names) {
        if (name == known) return unit;
    }
    return std::nullopt;
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

TopoDS_Shape read_step(const Path& path, const base::Progress& progress, ReadReport& report,
                       FaceAttributeMap& attributes) {
    const std::string text = check_step_file(path);
    ExchangeSession session;
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
    TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
    reader.FileUnits(lengths, angles, solid_angles);
    for (int i = 1; i <= lengths.Length(); ++i) {
        const auto unit = unit_by_name(lengths(i).ToCString());
        if (!unit) {
            report.notices.push_back(
                fmt::format("{}: unit '{}' has no short name here; lengths are right, "
                            "reports use mm",
                            path.string(), lengths(i).ToCString()));
        } else if (i == 1) {
            report.unit = *unit;
        } else if (*unit != report.unit) {
            report.notices.push_back(fmt::format("{}: parts are in different units ({} and {})",
                                                 path.string(), base::short_name(report.unit),
                                                 base::short_name(*unit)));
        }
    }
    transfer_roots(reader, progress);
    attributes = step_attributes(reader);
    TopoDS_Shape shape = reader.OneShape();
    report.lost = lost_in_step(reader, shape, text);
    return shape;
}

TopoDS_Shape read_iges(const Path& path, const base::Progress& progress, ReadReport& report,
                       FaceAttributeMap& attributes) {
    const auto repair = repair_iges(check_iges_file(path));
    std::optional<TemporaryFile> repaired;
    if (repair) {
        repaired.emplace(repair->text, ".igs");
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
    switch (global.UnitFlag()) {
        case 1: report.unit = base::LengthUnit::Inch; break;
        case 4: report.unit = base::LengthUnit::Foot; break;
        case 6: report.unit = base::LengthUnit::Metre; break;
        case 10: report.unit = base::LengthUnit::Centimetre; break;
        case 3:
            if (const auto unit = unit_by_name(text_of(global.UnitName()))) report.unit = *unit;
            break;
        case 2: break;
        default:
            report.notices.push_back(
                fmt::format("{}: unit flag {} has no short name here; lengths are "
                            "right, reports use mm",
                            path.string(), global.UnitFlag()));
    }
    transfer_roots(reader, progress);
    attributes = iges_attributes(reader);
    TopoDS_Shape shape = reader.OneShape();
    report.lost = lost_in_iges(reader, shape);
    return shape;
}

TopoDS_Shape read_brep(const Path& path) {
    check_brep_file(path);
    // This reader prints on std::cout what it does not like.
    const ExchangeSession session;
    TopoDS_Shape shape;
    if (!BRepTools::Read(shape, path.c_str(), BRep_Builder())) {
        refuse(path, "is not readable as BREP; get a complete copy");
    }
    return shape;
}

int face_count(const TopoDS_Shape& shape) {
    TopTools_IndexedMapOfShape map;
    if (!shape.IsNull()) TopExp::MapShapes(shape, TopAbs_FACE, map);
    return map.Extent();
}

void apply_unit_override(TopoDS_Shape& shape, const ReadOptions& options, ReadReport& report,
                         FaceOrigins& origins) {
    if (!options.unit || *options.unit == report.unit) return;
    gp_Trsf scale;
    scale.SetScaleFactor(base::millimetres_per(*options.unit) / base::millimetres_per(report.unit));
    BRepBuilderAPI_Transform scaled(shape, scale, true);
    for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
        origins.replaced(it.Current(), scaled.ModifiedShape(it.Current()));
    shape = scaled.Shape();
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
        FaceAttributeMap attributes;
        TopoDS_Shape shape = report.format == FileFormat::Step
                                 ? read_step(path, options.progress, report, attributes)
                             : report.format == FileFormat::Iges
                                 ? read_iges(path, options.progress, report, attributes)
                                 : read_brep(path);
        for (const LostEntity& lost : report.lost)
            report.notices.push_back(fmt::format("{}: {} {} is lost{}{}", path.string(),
                                                 lost.entity, lost.type, lost.reason ? ": " : "",
                                                 lost.reason.value_or("")));
        report.faces_in_file = face_count(shape);
        if (report.faces_in_file == 0) {
            refuse(path,
                   "holds no faces that the CAD kernel can transfer; export it anew with surfaces");
        }
        base::report_progress(options.progress, "read", 0.5);
        FaceOrigins origins;
        apply_unit_override(shape, options, report, origins);
        shape = keep_faces(shape);
        report.free_edges_before = count_free_edges(shape);
        impl->shape = options.heal ? heal(shape, options.max_sewing_tolerance_rel, report, origins,
                                          options.progress)
                                   : shape;
        report.free_edges_after = count_free_edges(impl->shape);
        for (const TopoDS_Face& face : faces_of(CadModel(impl))) {
            const FaceAttributes& given = attributes[origins.origin(face)];
            impl->face_names.push_back(given.name);
            impl->face_colours.push_back(given.colour);
        }
    });
    base::report_progress(options.progress, "read", 1.0);
    return {CadModel(std::move(impl)), std::move(report)};
}

}  // namespace patchwright::occ
