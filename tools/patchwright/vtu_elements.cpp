#include "vtu_elements.h"

#include <patchwright/base/error.h>

#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <new>
#include <utility>

namespace patchwright::cli {

namespace {

/// Follows expat's events. Raw data end the XML, and are not parsed.
class VtuParser {
  public:
    VtuParser(const std::string& file, std::string_view content)
        : file_(file), content_(content), parser_(XML_ParserCreate(nullptr), XML_ParserFree) {
        if (!parser_) throw std::bad_alloc();
        XML_SetUserData(parser_.get(), this);
        XML_SetElementHandler(
            parser_.get(),
            [](void* self, const char* name, const char** attributes) {
                static_cast<VtuParser*>(self)->guarded(
                    [&](VtuParser& parser) { parser.begin(name, attributes); });
            },
            [](void* self, const char*) {
                static_cast<VtuParser*>(self)->guarded([](VtuParser& parser) { parser.end(); });
            });
        XML_SetStartDoctypeDeclHandler(
            parser_.get(), [](void* self, const char*, const char*, const char*, int) {
                static_cast<VtuParser*>(self)->guarded([](VtuParser& parser) {
                    parser.refuse("has a document type, which VTK's files have not");
                });
            });
    }

    VtuElements parse() {
        constexpr std::size_t most = 1 << 30;
        std::string_view rest = content_;
        XML_Status status = XML_STATUS_OK;
        do {
            const std::size_t size = std::min(rest.size(), most);
            status = XML_Parse(parser_.get(), rest.data(), static_cast<int>(size),
                               size == rest.size() ? 1 : 0);
            rest.remove_prefix(size);
        } while (status == XML_STATUS_OK && !rest.empty());
        if (error_) std::rethrow_exception(error_);
        if (status != XML_STATUS_OK && !is_at_data_)
            refuse(XML_ErrorString(XML_GetErrorCode(parser_.get())));
        if (stack_.empty() && !has_root_) refuse("has no element VTKFile");
        return std::move(elements_);
    }

  private:
    /// Exceptions must not cross expat, which is C.
    template <class Body>
    void guarded(const Body& body) noexcept {
        if (error_) return;
        try {
            body(*this);
        } catch (...) {
            error_ = std::current_exception();
            XML_StopParser(parser_.get(), XML_FALSE);
        }
    }
    [[nodiscard]] std::uint64_t line() const { return XML_GetCurrentLineNumber(parser_.get()); }
    [[noreturn]] void refuse(const std::string& what) const {
        throw base::InputError(fmt::format("{}, line {}: {}", file_, line(), what));
    }
    [[nodiscard]] std::size_t event_begin() const {
        return static_cast<std::size_t>(XML_GetCurrentByteIndex(parser_.get()));
    }
    [[nodiscard]] std::size_t event_end() const {
        return event_begin() + static_cast<std::size_t>(XML_GetCurrentByteCount(parser_.get()));
    }

    void begin(const std::string& name, const char** given) {
        std::map<std::string, std::string> attributes;
        for (; given[0] != nullptr; given += 2) {
            std::string& value = attributes[given[0]] = given[1];
            // Messages that name it are one line.
            std::replace_if(
                value.begin(), value.end(), [](char c) { return c >= 0 && c < ' '; }, ' ');
        }
        end_text();
        if (!has_root_) begin_file(name, attributes);
        if (name == "Piece") {
            elements_.pieces.push_back(
                {attributes["NumberOfPoints"], attributes["NumberOfCells"], {}});
        } else if (name == "DataArray" && !elements_.pieces.empty()) {
            elements_.pieces.back().arrays.push_back(
                {stack_.empty() ? "" : stack_.back(), std::move(attributes), {}, line()});
            text_begin_ = event_end();
            in_text_ = true;
        } else if (name == "AppendedData") {
            begin_data(attributes["encoding"]);
        }
        stack_.push_back(name);
    }
    void end() {
        end_text();
        stack_.pop_back();
    }
    /// What VTK writes into an array after its numbers are elements.
    void end_text() {
        if (!in_text_) return;
        in_text_ = false;
        const std::size_t end = std::max(event_begin(), text_begin_);
        elements_.pieces.back().arrays.back().text =
            content_.substr(text_begin_, end - text_begin_);
    }
    void begin_file(const std::string& name, std::map<std::string, std::string>& attributes) {
        has_root_ = true;
        if (name != "VTKFile")
            refuse(fmt::format("<{}> is no VTK file; UnstructuredGrid (.vtu) is needed", name));
        if (attributes["type"] != "UnstructuredGrid")
            refuse(fmt::format("<VTKFile type=\"{}\">; UnstructuredGrid (.vtu) is needed",
                               attributes["type"]));
        const std::string &order = attributes["byte_order"], &header = attributes["header_type"],
                          &compressor = attributes["compressor"];
        if (order != "BigEndian" && order != "LittleEndian" && !order.empty())
            refuse(fmt::format("<VTKFile byte_order=\"{}\">; BigEndian or LittleEndian", order));
        if (header != "UInt32" && header != "UInt64" && !header.empty())
            refuse(fmt::format("<VTKFile header_type=\"{}\">; UInt32 or UInt64", header));
        if (compressor != "vtkZLibDataCompressor" && !compressor.empty())
            refuse(
                fmt::format("<VTKFile compressor=\"{}\">; write it with "
                            "vtkZLibDataCompressor or without (SetCompressorTypeToNone)",
                            compressor));
        elements_.encoding = {order == "BigEndian", header == "UInt64" ? 8u : 4u,
                              !compressor.empty()};
    }
    void begin_data(const std::string& encoding) {
        if (encoding != "raw" && encoding != "base64")
            refuse(fmt::format("<AppendedData encoding=\"{}\">; raw or base64", encoding));
        elements_.has_appended_base64 = encoding == "base64";
        const std::size_t underscore = content_.find('_', event_end());
        if (underscore == std::string_view::npos)
            refuse("<AppendedData> has no underscore where its data begin");
        elements_.appended = content_.substr(underscore + 1);
        is_at_data_ = true;
        XML_StopParser(parser_.get(), XML_FALSE);
    }

    const std::string& file_;
    std::string_view content_;
    std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser_;
    VtuElements elements_;
    std::vector<std::string> stack_;
    std::exception_ptr error_;
    std::size_t text_begin_ = 0;
    bool in_text_ = false, has_root_ = false, is_at_data_ = false;
};

}  // namespace

std::string VtuArray::attribute(const std::string& name) const {
    const auto found = attributes.find(name);
    return found == attributes.end() ? std::string() : found->second;
}

VtuElements parse_vtu(const std::string& file, std::string_view content) {
    return VtuParser(file, content).parse();
}

}  // namespace patchwright::cli
