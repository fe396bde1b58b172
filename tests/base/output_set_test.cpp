#include <patchwright/base/error.h>
#include <patchwright/base/output_set.h>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <string>
#include <thread>

using namespace patchwright;
namespace fs = std::filesystem;

namespace {

class OutputFolder {
  public:
    OutputFolder() {
        std::string name = (fs::temp_directory_path() / "patchwright_XXXXXX").string();
        REQUIRE(mkdtemp(name.data()) != nullptr);
        path_ = name;
    }
    ~OutputFolder() { fs::remove_all(path_); }
    OutputFolder(const OutputFolder&) = delete;
    OutputFolder& operator=(const OutputFolder&) = delete;

    [[nodiscard]] fs::path operator/(const char* name) const { return path_ / name; }
    [[nodiscard]] fs::path old(const char* name) const {
        std::ofstream(path_ / name) << "old";
        return path_ / name;
    }
    [[nodiscard]] int size() const { return int(std::distance(fs::directory_iterator(path_), {})); }

  private:
    fs::path path_;
};

std::string text_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

TEST_CASE("outputs appear together and keep what was there before until then", "[base]") {
    const OutputFolder folder;
    const fs::path a = folder.old("a.txt"), b = folder / "b.txt";
    fs::permissions(a, fs::perms(0640));
    base::OutputSet outputs;
    outputs.add(a, "new a");
    outputs.add(b, "new b");
    CHECK(text_of(a) == "old");
    CHECK_FALSE(fs::exists(b));
    outputs.commit();
    CHECK(text_of(a) == "new a");
    CHECK(text_of(b) == "new b");
    CHECK(fs::status(a).permissions() == fs::perms(0640));
    CHECK(folder.size() == 2);
}

TEST_CASE("outputs that are not put in place leave nothing", "[base]") {
    const OutputFolder folder;
    const fs::path a = folder.old("a.txt");
    {
        base::OutputSet outputs;
        outputs.add(a, "new");
        outputs.add(folder / "b.txt", "new");
        CHECK(folder.size() == 3);
    }
    CHECK(text_of(a) == "old");
    CHECK(folder.size() == 1);
}

TEST_CASE("a rename that fails undoes those before it", "[base]") {
    const OutputFolder folder;
    const fs::path a = folder.old("a.txt"), b = folder / "b.txt", c = folder / "c.txt";
    {
        base::OutputSet outputs;
        outputs.add(a, "new");
        outputs.add(b, "new");
        outputs.add(c, "new");
        fs::create_directories(c / "in the way");
        CHECK_THROWS_AS(outputs.commit(), base::OutputError);
    }
    CHECK(text_of(a) == "old");
    CHECK_FALSE(fs::exists(b));
    CHECK(folder.size() == 2);
}

TEST_CASE("symbolic links lead to the file that is written", "[base]") {
    const OutputFolder folder, elsewhere;
    const fs::path file = elsewhere.old("a.txt"), link = folder / "link.txt";
    fs::create_symlink(file, link);
    fs::create_symlink("link.txt", folder / "second.txt");
    base::OutputSet outputs;
    outputs.add(folder / "second.txt", "new");
    outputs.commit();
    CHECK(text_of(file) == "new");
    CHECK(fs::is_symlink(link));
    CHECK(elsewhere.size() == 1);
    fs::create_symlink(elsewhere / "none.txt", folder / "dangling.txt");
    outputs.add(folder / "dangling.txt", "new");
    outputs.commit();
    CHECK(text_of(elsewhere / "none.txt") == "new");
}

TEST_CASE("what cannot be written is refused at once", "[base]") {
    const OutputFolder folder;
    const fs::path a = folder.old("a.txt");
    fs::permissions(a, fs::perms(0444));
    fs::create_symlink("loop.txt", folder / "loop.txt");
    fs::create_directory(folder / "folder.txt");
    fs::create_directory(folder / "read-only");
    fs::permissions(folder / "read-only", fs::perms(0555));
    for (const char* name :
         {"a.txt", "loop.txt", "folder.txt", "none/a.txt", "a.txt/b.txt", "read-only/a.txt"}) {
        INFO(name);
        CHECK_THROWS_AS(base::OutputTarget(folder / name), base::OutputError);
    }
}

TEST_CASE("a pipe is written to and stays a pipe", "[base]") {
    const OutputFolder folder;
    const fs::path pipe = folder / "pipe.txt";
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    std::string read;
    std::thread reader([&] { read = text_of(pipe); });
    base::OutputSet outputs;
    outputs.add(pipe, "through the pipe");
    outputs.commit();
    reader.join();
    CHECK(read == "through the pipe");
    CHECK(fs::is_fifo(pipe));
    CHECK(folder.size() == 1);
}

TEST_CASE("parts come with their file, and older ones go", "[base]") {
    const OutputFolder folder;
    for (const std::string content : {"first", "second"}) {
        base::OutputSet outputs;
        const auto file = std::make_shared<base::PendingFile>(folder / "a.txt");
        std::ofstream(file->part("a/0.txt")) << content;
        if (content == "first") std::ofstream(file->part("a/1.txt")) << content;
        if (content == "second") file->drop("a/1.txt");
        file->write(content);
        outputs.add(file);
        CHECK(fs::exists(folder / "a") == (content == "second"));
        outputs.commit();
        CHECK(text_of(folder / "a/0.txt") == content);
        CHECK(text_of(folder / "a.txt") == content);
        CHECK(fs::exists(folder / "a/1.txt") == (content == "first"));
    }
    CHECK(folder.size() == 2);
}

TEST_CASE("only the user may enter the folder of a pending file", "[base]") {
    const OutputFolder folder;
    const base::PendingFile a(folder / "a.txt"), b(folder / "a.txt");
    CHECK(a.path() != b.path());
    CHECK(a.path().filename() == "a.txt");
    CHECK(fs::status(a.path().parent_path()).permissions() == fs::perms::owner_all);
    const std::string name = a.path().parent_path().filename().string();
    CHECK(name.starts_with(base::pending_prefix));
    CHECK(name.size() == base::pending_prefix.size() + 16);
}

TEST_CASE("a process that ends at once can remove its pending files", "[base]") {
    const OutputFolder folder;
    const fs::path a = folder.old("a.txt");
    const pid_t child = ::fork();
    if (child == 0) {
        base::OutputSet outputs;
        outputs.add(a, "new");
        base::abandon_pending_files();
        ::_exit(0);
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(status == 0);
    CHECK(text_of(a) == "old");
    CHECK(folder.size() == 1);
}
