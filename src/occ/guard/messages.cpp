#include "occ/guard/messages.h"

#include <sys/socket.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace patchwright::occ {

namespace {

/// The kind, then the length of what follows.
constexpr std::size_t head_size = 1 + sizeof(std::uint64_t);

void send_bytes(int descriptor, const char* bytes, std::size_t count) {
    while (count > 0) {
        const ssize_t written = ::send(descriptor, bytes, count, MSG_NOSIGNAL);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) std::_Exit(EXIT_FAILURE);
        bytes += written;
        count -= std::size_t(written);
    }
}

}  // namespace

void send_message(int descriptor, MessageKind kind, std::string_view content) {
    char head[head_size];
    const std::uint64_t length = content.size();
    head[0] = static_cast<char>(kind);
    std::memcpy(head + 1, &length, sizeof length);
    send_bytes(descriptor, head, head_size);
    send_bytes(descriptor, content.data(), content.size());
}

std::optional<Message> MessageBuffer::next() {
    if (bytes_.size() < head_size) return std::nullopt;
    std::uint64_t length = 0;
    std::memcpy(&length, bytes_.data() + 1, sizeof length);
    if (bytes_.size() - head_size < length) return std::nullopt;
    Message message{static_cast<MessageKind>(bytes_[0]), bytes_.substr(head_size, length)};
    bytes_.erase(0, head_size + length);
    return message;
}

}  // namespace patchwright::occ
