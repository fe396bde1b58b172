#include "base/pending_folders.h"

#include <patchwright/base/error.h>
#include <patchwright/base/output_set.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace patchwright::base {

namespace {

namespace fs = std::filesystem;

constexpr int most_links = 40;  // as the kernel follows
constexpr std::size_t copied_at_once = 1 << 16;
constexpr mode_t writable_by_any = S_IWUSR | S_IWGRP | S_IWOTH;

[[noreturn]] void refuse_output(const fs::path& given, std::string_view what) {
    throw OutputError(fmt::format("{}: {}", given.string(), what));
}
[[noreturn]] void refuse_output(const fs::path& given, std::string_view what, int error) {
    refuse_output(given, fmt::format("{}: {}", what, std::strerror(error)));
}

/// Root may write what is marked read-only; here the mark counts.
bool is_writable(const fs::path& path, mode_t mode) {
    return (mode & writable_by_any) != 0 && ::access(path.c_str(), W_OK) == 0;
}

/// The file that symbolic links lead to; it may not be there.
fs::path follow_links(const fs::path& given) {
    fs::path file = given;
    for (int links = 0; links < most_links; ++links) {
        std::error_code error;
        const fs::path next = fs::read_symlink(file, error);
        if (error) return file;
        file = file.parent_path() / next;  // an absolute one replaces the folder
    }
    refuse_output(given, "cannot be written", ELOOP);
}

/// A file that is closed at the end.
class Descriptor {
  public:
    Descriptor(const fs::path& path, int flags, const fs::path& given)
        : number_(::open(path.c_str(), flags | O_CLOEXEC | O_NOCTTY, 0666)), given_(given) {
        if (number_ < 0) fail(errno);
    }
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    void write(std::string_view bytes) const {
        while (!bytes.empty()) {
            const ssize_t count = ::write(number_, bytes.data(), bytes.size());
            if (count < 0 && errno == EINTR) continue;
            if (count < 0) fail(errno);
            bytes.remove_prefix(std::size_t(count));
        }
    }
    /// @return how many bytes there were; 0 at the end
    std::size_t read(char* bytes, std::size_t size) const {
        for (;;) {
            const ssize_t count = ::read(number_, bytes, size);
            if (count >= 0) return std::size_t(count);
            if (errno != EINTR) fail(errno);
        }
    }
    void flush() const {
        if (::fsync(number_) != 0) fail(errno);
    }
    void set_mode(mode_t mode) const {
        if (::fchmod(number_, mode) != 0) fail(errno);
    }
    /// Some file systems tell here what could not be written.
    void close() {
        const int number = std::exchange(number_, -1);
        if (::close(number) != 0) fail(errno);
    }

  private:
    [[noreturn]] void fail(int error) const { refuse_output(given_, "cannot be written", error); }

    int number_;
    fs::path given_;
};

void check_content(const Descriptor& file, std::string_view content, const fs::path& given) {
    std::vector<char> bytes(copied_at_once);
    for (;;) {
        const std::string_view part(bytes.data(), file.read(bytes.data(), bytes.size()));
        if (part.empty() && content.empty()) return;
        if (part.empty() || !content.starts_with(part))
            refuse_output(given, "is not what was written when it is read back; disk failure?");
        content.remove_prefix(part.size());
    }
}

}  // namespace

OutputTarget::OutputTarget(fs::path path) : given(std::move(path)), file(given) {
    struct stat found {};
    const bool exists = ::stat(given.c_str(), &found) == 0;
    if (!exists && errno != ENOENT) refuse_output(given, "cannot be written", errno);
    if (exists && S_ISDIR(found.st_mode)) refuse_output(given, "is a folder; give a file name");
    if (exists && !S_ISREG(found.st_mode)) {
        is_stream = true;
        if (!is_writable(given, found.st_mode)) refuse_output(given, "is read-only");
        return;
    }
    file = follow_links(given);
    if (file.filename().empty()) refuse_output(given, "is no file name");
    if (exists) {
        mode = fs::perms(found.st_mode) & fs::perms::mask;
        if (!is_writable(file, found.st_mode)) refuse_output(given, "is read-only");
    }
    struct stat at {};
    if (::stat(folder().c_str(), &at) != 0 || !S_ISDIR(at.st_mode))
        refuse_output(given, "the folder does not exist; create it first");
    if (!is_writable(folder(), at.st_mode)) refuse_output(given, "the folder is read-only");
}

fs::path OutputTarget::folder() const {
    return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

PendingFile::PendingFile(const fs::path& given)
    : target_(given),
      private_folder_(make_pending_folder(
          target_.is_stream ? fs::temp_directory_path() : target_.folder(), given)) {}

PendingFile::~PendingFile() { remove_pending_folder(private_folder_); }

fs::path PendingFile::path() const { return private_folder_ / target_.file.filename(); }

fs::path PendingFile::part(const fs::path& relative) {
    const fs::path final = target_.folder() / relative;
    struct stat found {};
    if (::lstat(final.c_str(), &found) == 0 && S_ISREG(found.st_mode)) OutputTarget{final};
    fs::path pending = private_folder_ / relative;
    std::error_code error;
    fs::create_directory(pending.parent_path(), error);
    if (error) refuse_output(final, "cannot be written", error.value());
    parts_.push_back(relative);
    return pending;
}

void PendingFile::write(std::string_view content) {
    Descriptor out(path(), O_WRONLY | O_CREAT | O_EXCL, target_.given);
    out.write(content);
    out.flush();
    out.close();
    check_content(Descriptor(path(), O_RDONLY, target_.given), content, target_.given);
}

std::vector<fs::path> PendingFile::relatives() const {
    std::vector<fs::path> all = parts_;
    all.push_back(target_.file.filename());
    return all;
}

void PendingFile::flush() const {
    for (const fs::path& name : relatives()) {
        const Descriptor file(private_folder_ / name, O_RDONLY | O_NOFOLLOW, target_.given);
        if (target_.mode && name == target_.file.filename()) file.set_mode(mode_t(*target_.mode));
        file.flush();
    }
}

void PendingFile::copy_to_stream() const {
    const Descriptor from(path(), O_RDONLY, target_.given);
    Descriptor to(target_.given, O_WRONLY, target_.given);
    std::array<char, copied_at_once> bytes{};
    while (const std::size_t count = from.read(bytes.data(), bytes.size()))
        to.write({bytes.data(), count});
    to.close();
}

}  // namespace patchwright::base
