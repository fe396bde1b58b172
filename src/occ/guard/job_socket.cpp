#include "occ/guard/job_socket.h"

#include <sys/socket.h>
#include <sys/uio.h>

#include <cerrno>
#include <climits>
#include <cstring>

namespace patchwright::occ {

namespace {

/// A path, and a few numbers.
constexpr std::size_t largest_request = PATH_MAX + 1024;

/// Room for one descriptor beside the bytes of a packet.
union Beside {
    char bytes[CMSG_SPACE(sizeof(int))];
    cmsghdr align;
};

template <class Call>
ssize_t repeat(const Call& call) {
    for (;;) {
        const ssize_t result = call();
        if (result >= 0 || errno != EINTR) return result;
    }
}

}  // namespace

bool send_job(int control, const Job& job) {
    std::string request = job.request;
    iovec bytes{request.data(), request.size()};
    Beside beside{};
    msghdr packet{};
    packet.msg_iov = &bytes;
    packet.msg_iovlen = 1;
    packet.msg_control = beside.bytes;
    packet.msg_controllen = sizeof beside.bytes;
    cmsghdr* head = CMSG_FIRSTHDR(&packet);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(head), &job.channel, sizeof(int));
    return repeat([&] { return ::sendmsg(control, &packet, MSG_NOSIGNAL); }) > 0;
}

std::optional<Job> receive_job(int control) {
    Job job{std::string(largest_request, '\0')};
    iovec bytes{job.request.data(), job.request.size()};
    Beside beside{};
    msghdr packet{};
    packet.msg_iov = &bytes;
    packet.msg_iovlen = 1;
    packet.msg_control = beside.bytes;
    packet.msg_controllen = sizeof beside.bytes;
    const ssize_t count = repeat([&] { return ::recvmsg(control, &packet, MSG_CMSG_CLOEXEC); });
    const cmsghdr* head = CMSG_FIRSTHDR(&packet);
    if (count <= 0 || head == nullptr) return std::nullopt;
    job.request.resize(std::size_t(count));
    std::memcpy(&job.channel, CMSG_DATA(head), sizeof(int));
    return job;
}

bool send_status(int control, int status) {
    return repeat([&] { return ::send(control, &status, sizeof status, MSG_NOSIGNAL); }) > 0;
}

std::optional<int> receive_status(int control) {
    int status = 0;
    if (repeat([&] { return ::recv(control, &status, sizeof status, 0); }) != sizeof status)
        return std::nullopt;
    return status;
}

}  // namespace patchwright::occ
