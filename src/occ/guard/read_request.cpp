#include "occ/guard/read_request.h"

#include "occ/guard/archive.h"

#include <sstream>

namespace patchwright::occ {

namespace {

template <class Archive, class Request>
void each_request_field(Archive& archive, Request& request) {
    archive(request.task);
    archive(request.options.unit);
    archive(request.options.allow_loss);
    archive(request.options.heal);
    archive(request.options.max_sewing_tolerance_rel);
    archive(request.threads);
    archive(request.processor_s);
    archive(request.memory_mb);
}

}  // namespace

std::string pack_request(const ReadRequest& request) {
    std::ostringstream stream;
    Packer archive(stream);
    archive(request.file.string());
    each_request_field(archive, request);
    return std::move(stream).str();
}

ReadRequest unpack_request(const std::string& bytes) {
    std::istringstream stream(bytes);
    Unpacker archive(stream);
    ReadRequest request;
    std::string file;
    archive(file);
    request.file = file;
    each_request_field(archive, request);
    return request;
}

}  // namespace patchwright::occ
