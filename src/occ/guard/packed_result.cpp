#include "occ/guard/packed_result.h"

#include "occ/exchange/cad_model_impl.h"
#include "occ/kernel_guard.h"

#include <patchwright/base/error.h>

#include <BinTools.hxx>

#include <cstdint>
#include <cstring>
#include <sstream>
#include <type_traits>

namespace patchwright::occ {

namespace {

class Packer {
  public:
    explicit Packer(std::ostream& out) : out_(out) {}

    template <class T>
    void operator()(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        out_.write(reinterpret_cast<const char*>(&value), sizeof value);
    }
    void operator()(const std::string& text) {
        (*this)(std::uint64_t(text.size()));
        out_.write(text.data(), std::streamsize(text.size()));
    }
    template <class T>
    void operator()(const std::optional<T>& value) {
        (*this)(value.has_value());
        if (value) (*this)(*value);
    }
    template <class T>
    void operator()(const std::vector<T>& values) {
        (*this)(std::uint64_t(values.size()));
        for (const T& value : values) (*this)(value);
    }
    void operator()(const LostEntity& lost) {
        (*this)(lost.entity);
        (*this)(lost.type);
        (*this)(lost.reason);
    }

  private:
    std::ostream& out_;
};

class Unpacker {
  public:
    explicit Unpacker(std::istream& in) : in_(in) {}

    template <class T>
    void operator()(T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        in_.read(reinterpret_cast<char*>(&value), sizeof value);
        if (!in_) throw base::Error("the result of a reader process is cut off");
    }
    void operator()(std::string& text) {
        text.clear();
        for (auto left = size(); left > 0; --left) {
            text.push_back('\0');
            (*this)(text.back());
        }
    }
    template <class T>
    void operator()(std::optional<T>& value) {
        bool given = false;
        (*this)(given);
        value.reset();
        if (given) (*this)(value.emplace());
    }
    template <class T>
    void operator()(std::vector<T>& values) {
        values.clear();
        for (auto left = size(); left > 0; --left) (*this)(values.emplace_back());
    }
    void operator()(LostEntity& lost) {
        (*this)(lost.entity);
        (*this)(lost.type);
        (*this)(lost.reason);
    }

  private:
    std::uint64_t size() {
        std::uint64_t count = 0;
        (*this)(count);
        return count;
    }
    std::istream& in_;
};

/// The same order for both ways.
template <class Archive, class Report>
void each_field(Archive&& archive, Report& report) {
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
    archive(report.pcurves_replaced);
    archive(report.notices);
}

}  // namespace

std::string pack_result(const ReadResult& result) {
    std::ostringstream stream;
    const CadModel::Impl& impl = result.model.impl();
    Packer archive(stream);
    each_field(archive, result.report);
    archive(impl.face_names);
    archive(impl.face_colours);
    BinTools::Write(impl.shape, stream);
    return std::move(stream).str();
}

ReadResult unpack_result(std::string bytes) {
    std::istringstream stream(std::move(bytes));
    ReadReport report;
    auto impl = std::make_shared<CadModel::Impl>();
    Unpacker archive(stream);
    each_field(archive, report);
    archive(impl->face_names);
    archive(impl->face_colours);
    guard_kernel<base::Error>("result of a reader process",
                              [&] { BinTools::Read(impl->shape, stream); });
    if (impl->shape.IsNull()) throw base::Error("the result of a reader process has no shape");
    return {CadModel(std::move(impl)), std::move(report)};
}

}  // namespace patchwright::occ
