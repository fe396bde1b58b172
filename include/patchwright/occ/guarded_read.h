// Reading CAD files in a process of its own, which the kernel may bring down.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <filesystem>
#include <optional>

namespace patchwright::occ {

/// Who reads, and what of the machine it may take.
struct ReaderProcess {
    /// A program whose main() gives its arguments to serve_read(), as patchwright's does.
    std::filesystem::path program;
    /// Of processor time; none: 15 and 15 for each MB of the file, ten times what any known file
    /// takes.
    std::optional<double> time_limit_s;
    /// Of address space; none: 2048 and 512 for each MB of the file, twenty times what any known
    /// file takes.
    std::optional<double> memory_limit_mb;
};

/// The same as read_cad(), but the kernel works in a child process, which ends with this one.
/// @throw InputError as read_cad(); also when the kernel crashes, recurses without end or exceeds a
///        limit, with the entity that it was at where that is known
/// @throw Cancelled, TimeLimitReached from the progress callback; the child is gone then
/// @throw Error when the program is not such a one
ReadResult read_cad_guarded(const std::filesystem::path& path, const ReaderProcess& reader,
                            const ReadOptions& options = {});

/// The child's side, for the first line of main(). Does nothing unless the arguments are those of
/// a child, and returns to nobody then.
void serve_read(int argc, char** argv);

}  // namespace patchwright::occ
