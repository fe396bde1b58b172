#include "base/pending_folders.h"

#include <patchwright/base/error.h>
#include <patchwright/base/output_set.h>

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <mutex>
#include <optional>
#include <system_error>

namespace patchwright::base {

namespace {

namespace fs = std::filesystem;

/// One file on its way to its place.
struct Move {
    fs::path from, to, given;
    fs::path folder;         ///< of `to`
    fs::path backup;         ///< another name for the older file
    bool is_backed = false;  ///< there was one
    bool made_folder = false, done = false;
};

/// The renames of a commit: all of them, or none. Allocates nothing once they are all added.
class Moves {
  public:
    void add(fs::path from, fs::path to, fs::path given) {
        fs::path folder = to.parent_path();
        fs::path backup = from.parent_path() / fmt::format(".older{}", moves_.size());
        moves_.push_back({.from = std::move(from),
                          .to = std::move(to),
                          .given = std::move(given),
                          .folder = std::move(folder),
                          .backup = std::move(backup)});
    }

    /// @throw OutputError
    void carry_out() {
        std::unique_lock lock(pending_folders_mutex());
        const std::optional<Problem> problem = try_all();
        if (problem) undo();
        lock.unlock();
        if (problem)
            throw OutputError(fmt::format("{}: {}: {}", problem->move->given.string(),
                                          problem->what, std::strerror(problem->error)));
    }

  private:
    struct Problem {
        const Move* move;
        const char* what;
        int error;
    };

    std::optional<Problem> try_all() {
        for (Move& move : moves_) {
            move.made_folder = ::mkdir(move.folder.c_str(), 0777) == 0;
            if (!move.made_folder && errno != EEXIST)
                return Problem{&move, "its folder cannot be made", errno};
        }
        // The last rename needs no way back.
        for (std::size_t i = 0; i + 1 < moves_.size(); ++i) {
            Move& move = moves_[i];
            move.is_backed = ::link(move.to.c_str(), move.backup.c_str()) == 0;
            if (!move.is_backed && errno != ENOENT)
                return Problem{&move,
                               "the older file cannot be kept while several are replaced; write "
                               "one file at a time on this file system",
                               errno};
        }
        for (Move& move : moves_) {
            move.done = ::rename(move.from.c_str(), move.to.c_str()) == 0;
            if (!move.done) return Problem{&move, "cannot be put in its place", errno};
        }
        return std::nullopt;
    }

    void undo() const {
        for (const Move& move : moves_) {
            if (!move.done) continue;
            if (move.is_backed)
                ::rename(move.backup.c_str(), move.to.c_str());
            else
                ::unlink(move.to.c_str());
        }
        for (const Move& move : moves_)
            if (move.made_folder) ::rmdir(move.folder.c_str());
    }

    std::vector<Move> moves_;
};

}  // namespace

void OutputSet::add(const fs::path& given, std::string_view content) {
    auto file = std::make_shared<PendingFile>(given);
    file->write(content);
    add(std::move(file));
}

void OutputSet::commit() {
    for (const auto& file : files_) file->flush();
    for (const auto& file : files_)
        if (file->target_.is_stream) file->copy_to_stream();
    Moves moves;
    for (const auto& file : files_) {
        if (file->target_.is_stream) continue;
        const fs::path main = file->target_.file.filename();
        for (const fs::path& name : file->relatives())
            moves.add(file->private_folder_ / name, file->target_.folder() / name,
                      name == main ? file->target_.given : file->target_.folder() / name);
    }
    moves.carry_out();
    for (const auto& file : files_) {
        for (const fs::path& name : file->dropped_) {
            std::error_code ignored;
            fs::remove(file->target_.folder() / name, ignored);
        }
    }
    files_.clear();
}

}  // namespace patchwright::base
