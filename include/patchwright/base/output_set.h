// Output files appear complete, all files of a run together, or not at all.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::base {

/// Where the path of an output leads, symbolic links followed.
struct OutputTarget {
    /// @throw OutputError when nothing can be written there: a folder, a missing or read-only
    ///        folder, a read-only file, a loop of links
    explicit OutputTarget(std::filesystem::path given);

    [[nodiscard]] std::filesystem::path folder() const;

    std::filesystem::path given;                 ///< as messages name it
    std::filesystem::path file;                  ///< the file itself, there or not
    bool is_stream = false;                      ///< a device or a pipe: written to, never replaced
    std::optional<std::filesystem::perms> mode;  ///< of the file that is there
};

/// An output under construction: a file, which may have parts beside it (the blocks of a grid). All
/// are in a folder of their own in the target's folder, which nobody else may enter; its name is
/// pending_prefix and 16 random hexadecimal digits. The destructor removes what was not put in
/// place.
class PendingFile {
  public:
    /// @throw OutputError as OutputTarget, or when nothing can be made in the folder
    explicit PendingFile(const std::filesystem::path& given);
    ~PendingFile();
    PendingFile(const PendingFile&) = delete;
    PendingFile& operator=(const PendingFile&) = delete;

    /// Where to write. Has the final file's name, as kernels choose formats by it.
    [[nodiscard]] std::filesystem::path path() const;
    [[nodiscard]] const OutputTarget& target() const { return target_; }

    /// Where to write a part.
    /// @param relative  to the final file's folder; one folder deep at most
    std::filesystem::path part(const std::filesystem::path& relative);
    /// A part of an older output that the new one has not: removed when this one is in its place.
    void drop(const std::filesystem::path& relative) { dropped_.push_back(relative); }

    /// Writes the whole content, flushes it and reads it back.
    /// @throw OutputError
    void write(std::string_view content);

  private:
    friend class OutputSet;

    /// Parts first, so that what names them comes after them.
    [[nodiscard]] std::vector<std::filesystem::path> relatives() const;
    void flush() const;
    void copy_to_stream() const;

    OutputTarget target_;
    std::filesystem::path private_folder_;
    std::vector<std::filesystem::path> parts_, dropped_;
};

constexpr std::string_view pending_prefix = ".patchwright-";

/// The outputs of a run, put in place together.
class OutputSet {
  public:
    void add(std::shared_ptr<const PendingFile> file) { files_.push_back(std::move(file)); }
    /// @throw OutputError when it cannot be written
    void add(const std::filesystem::path& given, std::string_view content);

    /// Flushes all files, copies to devices and pipes, then renames. Empties the set.
    /// @throw OutputError when one cannot be written; all older files are as they were
    void commit();

  private:
    std::vector<std::shared_ptr<const PendingFile>> files_;
};

/// Removes what every PendingFile has written, for a process that is about to end without
/// unwinding; allocates nothing. From then on making, committing or destroying one blocks for good.
void abandon_pending_files() noexcept;

}  // namespace patchwright::base
#pragma GCC visibility pop
