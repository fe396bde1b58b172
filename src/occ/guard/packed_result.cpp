#include "occ/guard/packed_result.h"

#include "occ/exchange/cad_model_impl.h"
#include "occ/guard/archive.h"
#include "occ/kernel_guard.h"

#include <BinTools.hxx>

#include <sstream>

namespace patchwright::occ {

template <class Archive, class Lost>
requires std::is_same_v<std::remove_const_t<Lost>, LostEntity>
void each_field(Archive& archive, Lost& lost) {
    archive(lost.entity);
    archive(lost.type);
    archive(lost.reason);
}

namespace {

/// The same order for both ways.
template <class Archive, class Report>
void each_report_field(Archive& archive, Report& report) {
    archive(report.format);
    archive(report.schema);
    archive(report.originating_system);
    archive(report.unit);
    archive(report.faces_in_file);
    archive(report.lost);
    archive(report.free_edges_before);
    archive(report.free_edges_after);
    archive(report.sewn);
    archive(report.open_gaps);
    archive(report.duplicates_dropped);
    archive(report.slivers_dropped);
    archive(report.faces_turned);
    archive(report.edges_rejoined);
    archive(report.pcurves_projected);
    archive(report.pcurves_replaced);
    archive(report.notices);
}

}  // namespace

std::string pack_result(const ReadResult& result) {
    std::ostringstream stream;
    const CadModel::Impl& impl = result.model.impl();
    Packer archive(stream);
    each_report_field(archive, result.report);
    archive(impl.face_names);
    archive(impl.face_colours);
    BinTools::Write(impl.shape, stream);
    return std::move(stream).str();
}

ReadResult unpack_result(std::string bytes, const std::string& file) {
    std::istringstream stream(std::move(bytes));
    ReadReport report;
    auto impl = std::make_shared<CadModel::Impl>();
    Unpacker archive(stream);
    each_report_field(archive, report);
    archive(impl->face_names);
    archive(impl->face_colours);
    guard_kernel<base::InputError>(file, [&] { BinTools::Read(impl->shape, stream); });
    if (impl->shape.IsNull()) throw base::InputError(file + ": has no shape");
    return {CadModel(std::move(impl)), std::move(report)};
}

}  // namespace patchwright::occ
