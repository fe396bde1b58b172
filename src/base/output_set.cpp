#include "base/pending_folders.h"

#include <patchwright/base/error.h>
#include <patchwright/base/output_set.h>

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <mutex>
#include <string>
#include <system_error>

namespace patchwright::base {

namespace {

namespace fs = std::filesystem;

/// One file on its way to its place.
struct Move {
    fs::path from, to, given;
    fs::path backup;  ///< another name of the older file; empty: there was none
    bool done = false;
};

[[noreturn]] void refuse_move(const Move& move, const char* what, int error) {
    throw OutputError(fmt::format("{}: {}: {}", move.given.string(), what, std::strerror(error)));
}

/// The renames of a commit. Destroyed without keep() it puts back what was there before.
class Moves {
  public:
    ~Moves() {
        if (kept_) return;
        for (const Move& move : moves_) {
            if (!move.done) continue;
            if (move.backup.empty())
                ::unlink(move.to.c_str());
            else
                ::rename(move.backup.c_str(), move.to.c_str());
        }
        for (const fs::path& folder : made_folders_) ::rmdir(folder.c_str());
    }
    void add(Move move) { moves_.push_back(std::move(move)); }

    void carry_out() {
        for (Move& move : moves_) make_folder(move);
        // The last rename needs no way back.
        for (std::size_t i = 0; i + 1 < moves_.size(); ++i)
            back_up(moves_[i], fmt::format(".older{}", i));
        for (Move& move : moves_) {
            if (::rename(move.from.c_str(), move.to.c_str()) != 0)
                refuse_move(move, "cannot be put in its place", errno);
            move.done = true;
        }
        kept_ = true;
    }

  private:
    void make_folder(const Move& move) {
        const fs::path folder = move.to.parent_path();
        if (::mkdir(folder.c_str(), 0777) == 0)
            made_folders_.push_back(folder);
        else if (errno != EEXIST)
            refuse_move(move, "its folder cannot be made", errno);
    }
    static void back_up(Move& move, const std::string& name) {
        fs::path backup = move.from.parent_path() / name;
        if (::link(move.to.c_str(), backup.c_str()) == 0)
            move.backup = std::move(backup);
        else if (errno != ENOENT)
            refuse_move(move,
                        "the older file cannot be kept while several are replaced; write one file "
                        "at a time on this file system",
                        errno);
    }

    std::vector<Move> moves_;
    std::vector<fs::path> made_folders_;
    bool kept_ = false;
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
            moves.add({file->private_folder_ / name, file->target_.folder() / name,
                       name == main ? file->target_.given : file->target_.folder() / name});
    }
    {
        const std::lock_guard lock(pending_folders_mutex());
        moves.carry_out();
    }
    for (const auto& file : files_) {
        for (const fs::path& name : file->dropped_) {
            std::error_code ignored;
            fs::remove(file->target_.folder() / name, ignored);
        }
    }
    files_.clear();
}

}  // namespace patchwright::base
