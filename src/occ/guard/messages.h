// What a worker of a reader process tells, over a socket.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace patchwright::occ {

enum class MessageKind : char {
    Progress = 'p',     ///< fraction as text, blank, stage
    Entity = 'n',       ///< the entity that the kernel is given next
    Refusal = 'r',      ///< text of an InputError
    Failure = 'f',      ///< text of another error
    SystemError = 'e',  ///< errno as text
    Result = 'x'        ///< a ReadResult; see packed_result.h
};

struct Message {
    MessageKind kind;
    std::string content;
};

/// Blocks until all of it is sent. Ends the process when nobody listens.
void send_message(int descriptor, MessageKind kind, std::string_view content = {});

/// Collects bytes as they come.
class MessageBuffer {
  public:
    void append(std::string_view bytes) { bytes_ += bytes; }
    /// The first complete message, which is taken out.
    std::optional<Message> next();

  private:
    std::string bytes_;
};

}  // namespace patchwright::occ
