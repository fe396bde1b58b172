// The socket between a process and its reader: jobs one way, each with a socket for what is told
// about it, and how each ended the other way.
#pragma once

#include <optional>
#include <string>

namespace patchwright::occ {

struct Job {
    std::string request;  ///< see read_request.h
    int channel = -1;     ///< of the worker's messages
};

/// @return false when nobody takes jobs any more
bool send_job(int control, const Job& job);
/// @return nothing when nobody gives jobs any more
std::optional<Job> receive_job(int control);

/// @param status  as waitpid() tells it; or minus errno when there was no process for the job
bool send_status(int control, int status);
std::optional<int> receive_status(int control);

}  // namespace patchwright::occ
