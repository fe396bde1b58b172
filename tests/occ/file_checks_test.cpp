// Damage that the kernel's readers do not notice: they say "done", print, crash or loop forever.
#include "occ/shapes.h"

#include <patchwright/base/error.h>

#include <catch2/catch.hpp>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

using namespace patchwright;
using Catch::Matchers::Contains;

namespace {

class DamagedFile {
  public:
    explicit DamagedFile(const std::string& extension)
        : path_(std::filesystem::temp_directory_path() /
                ("patchwright_damaged_" + std::to_string(::getpid()) + extension)) {
        occ::write_cad(test::model_of(BRepPrimAPI_MakeCylinder(3.0, 5.0).Shape()), path_);
        std::ifstream stream(path_, std::ios::binary);
        std::stringstream content;
        content << stream.rdbuf();
        text = content.str();
    }
    ~DamagedFile() { std::filesystem::remove(path_); }
    DamagedFile(const DamagedFile&) = delete;
    DamagedFile& operator=(const DamagedFile&) = delete;

    void check_refused(const std::string& part) const {
        std::ofstream(path_, std::ios::binary) << text;
        CHECK_THROWS_WITH(occ::read_cad(path_),
                          Contains(path_.filename().string()) && Contains(part) && !Contains("\n"));
        CHECK_THROWS_AS(occ::read_cad(path_), base::InputError);
    }
    void check_accepted() const { CHECK_NOTHROW(read()); }
    void read() const {
        std::ofstream(path_, std::ios::binary) << text;
        occ::read_cad(path_);
    }

    std::string text;

  private:
    std::filesystem::path path_;
};

}  // namespace

TEST_CASE("an IGES file that lost lines is refused, whatever its end says", "[occ][errors]") {
    DamagedFile file(".igs");
    constexpr std::size_t line = 81;
    REQUIRE(file.text.size() % line == 0);
    const std::string whole = file.text;
    SECTION("in the middle") { file.text.erase(whole.size() / line / 2 * line, 5 * line); }
    SECTION("all but the terminate record") {
        file.text =
            whole.substr(0, whole.size() / line / 2 * line) + whole.substr(whole.size() - line);
    }
    file.check_refused("is incomplete: section");
}

TEST_CASE("an IGES file may have other line ends and a last empty line", "[occ]") {
    DamagedFile file(".igs");
    std::string other;
    for (const char c : file.text) other += c == '\n' ? std::string("\r\n") : std::string(1, c);
    file.text = other + "\r\n";
    file.check_accepted();
}

TEST_CASE("a STEP file needs a data section that ends", "[occ][errors]") {
    DamagedFile file(".step");
    const auto data = file.text.find("DATA;");
    REQUIRE(data != std::string::npos);
    SECTION("no section") {
        file.text = file.text.substr(0, data) + "END-ISO-10303-21;\n";
        file.check_refused("has no DATA section");
    }
    SECTION("no end") {
        file.text = file.text.substr(0, file.text.size() / 2) + "\nEND-ISO-10303-21;\n";
        file.check_refused("the DATA section does not end");
    }
    SECTION("the last bytes") {
        file.text.resize(file.text.size() - 8);
        file.check_refused("END-ISO-10303-21 is missing");
    }
}

TEST_CASE("a BREP file that is cut anywhere is refused", "[occ][errors]") {
    DamagedFile file(".brep");
    const std::string whole = file.text;
    // At 0.2 the kernel's reader loops forever, later it prints on std::cout.
    for (const double share : {0.05, 0.2, 0.5, 0.7, 0.9, 0.97}) {
        CAPTURE(share);
        file.text = whole.substr(0, std::size_t(share * double(whole.size())));
        file.check_refused("is cut off");
    }
    file.text = whole.substr(0, whole.find_last_of('*') + 1);
    file.check_refused("no root");
    file.text = whole;
    file.check_accepted();
}

TEST_CASE("the kernel prints nothing of its own", "[occ]") {
    // Complete, but with a surface of an unknown kind, of which the kernel tells std::cout.
    DamagedFile file(".brep");
    const auto surfaces = file.text.find("\nSurfaces ");
    REQUIRE(surfaces != std::string::npos);
    file.text.replace(file.text.find('\n', surfaces + 1) + 1, 1, "99");
    std::stringstream printed;
    std::streambuf* const before = std::cout.rdbuf(printed.rdbuf());
    CHECK_THROWS_AS(file.read(), base::InputError);
    CHECK(std::cout.rdbuf() == printed.rdbuf());
    std::cout.rdbuf(before);
    CHECK(printed.str().empty());
}
