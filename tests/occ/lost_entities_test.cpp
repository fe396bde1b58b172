// What the kernel's readers leave out of a model without an error is named.
#include "occ/exchange/exchange_session.h"
#include "occ/exchange/step_text.h"
#include "occ/shapes.h"

#include <patchwright/base/error.h>

#include <STEPControl_Writer.hxx>
#include <catch2/catch.hpp>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

using namespace patchwright;
using Catch::Matchers::Contains;

namespace {

/// A file that is written from a shape, edited as text and read again.
class EditedFile {
  public:
    EditedFile(const TopoDS_Shape& shape, const std::string& extension)
        : path_(std::filesystem::temp_directory_path() /
                ("patchwright_edited_" + std::to_string(::getpid()) + extension)) {
        occ::write_cad(test::model_of(shape), path_);
        std::ifstream stream(path_, std::ios::binary);
        std::stringstream content;
        content << stream.rdbuf();
        text = content.str();
    }
    ~EditedFile() { std::filesystem::remove(path_); }
    EditedFile(const EditedFile&) = delete;
    EditedFile& operator=(const EditedFile&) = delete;

    /// Replaces the first match, which must be there.
    void edit(const std::string& pattern, const std::string& with) {
        const std::regex expression(pattern);
        REQUIRE(std::regex_search(text, expression));
        text = std::regex_replace(text, expression, with, std::regex_constants::format_first_only);
    }
    /// Text of the first match's group.
    [[nodiscard]] std::string find(const std::string& pattern) const {
        std::smatch match;
        REQUIRE(std::regex_search(text, match, std::regex(pattern)));
        return match[1];
    }
    [[nodiscard]] occ::ReadReport read() const {
        std::ofstream(path_, std::ios::binary) << text;
        return occ::read_cad(path_, {.allow_loss = true}).report;
    }
    void check_refused(const std::string& part) const {
        std::ofstream(path_, std::ios::binary) << text;
        CHECK_THROWS_AS(occ::read_cad(path_), base::InputError);
        CHECK_THROWS_WITH(occ::read_cad(path_), Contains(part) && Contains("--allow-loss"));
    }

    std::string text;

  private:
    std::filesystem::path path_;
};

TopoDS_Shape box() { return BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape(); }
TopoDS_Shape cylinder() { return BRepPrimAPI_MakeCylinder(3.0, 5.0).Shape(); }

}  // namespace

TEST_CASE("nothing is lost of whole files", "[occ][lost]") {
    for (const char* extension : {".step", ".igs", ".brep"}) {
        for (const TopoDS_Shape& shape : {box(), cylinder(), test::wing()}) {
            CAPTURE(extension);
            const occ::ReadReport report = EditedFile(shape, extension).read();
            CHECK(report.lost.empty());
            CHECK(report.notices.empty());
        }
    }
}

TEST_CASE("an assembly of one part in two places loses nothing", "[occ][lost]") {
    gp_Trsf move;
    move.SetTranslation(gp_Vec(10.0, 0.0, 0.0));
    const TopoDS_Shape part = box();
    TopoDS_Compound pair;
    const BRep_Builder builder;
    builder.MakeCompound(pair);
    builder.Add(pair, part);
    builder.Add(pair, part.Moved(TopLoc_Location(move)));
    const auto path =
        std::filesystem::temp_directory_path() / (std::to_string(::getpid()) + "pair.step");
    {
        occ::ExchangeSession session;
        session.set("write.step.assembly", 1);
        STEPControl_Writer writer;
        writer.Transfer(pair, STEPControl_AsIs);
        writer.Write(path.c_str());
    }
    const occ::ReadReport report = occ::read_cad(path).report;
    std::filesystem::remove(path);
    CHECK(report.faces_in_file == 12);
    CHECK(report.lost.empty());
}

TEST_CASE("a face of an unknown type is lost by its number", "[occ][lost]") {
    EditedFile file(box(), ".step");
    const std::string number = file.find("(#[0-9]+)=ADVANCED_FACE");
    file.edit("ADVANCED_FACE", "FANCY_FACE");
    // A comment and a text that looks like a reference are neither.
    file.edit("CLOSED_SHELL\\(''", "/* #1; */ CLOSED_SHELL('#2;'");
    const occ::ReadReport report = file.read();
    CHECK(report.faces_in_file == 5);
    REQUIRE(report.lost.size() == 1);
    CHECK(report.lost[0].entity == number);
    CHECK(report.lost[0].type == "FANCY_FACE");
    REQUIRE_FALSE(report.notices.empty());
    CHECK_THAT(report.notices.front(), Contains(number + " FANCY_FACE: unknown entity is lost"));
    file.check_refused("but not " + number + " FANCY_FACE: unknown entity;");
}

TEST_CASE("a face is lost with its surface", "[occ][lost]") {
    EditedFile file(cylinder(), ".step");
    const std::string surface = file.find("(#[0-9]+)=CYLINDRICAL_SURFACE");
    const std::string face = file.find("(#[0-9]+)=ADVANCED_FACE\\([^;]*" + surface + ",");
    std::string reason;
    SECTION("of an unknown type") {
        file.edit("CYLINDRICAL_SURFACE", "FANCY_SURFACE");
        reason = "type of its surface is not known";
    }
    SECTION("with a negative radius") {
        file.edit("(CYLINDRICAL_SURFACE\\('',#[0-9]+,)3", "$01-3");
        reason = "Surface has not been created";
    }
    const occ::ReadReport report = file.read();
    CHECK(report.faces_in_file == 2);
    REQUIRE(report.lost.size() == 1);
    CHECK(report.lost[0].entity == face);
    CHECK(report.lost[0].type == "ADVANCED_FACE");
    REQUIRE(report.lost[0].reason);
    CHECK_THAT(*report.lost[0].reason, Contains(reason));
}

TEST_CASE("faces that nothing refers to are lost", "[occ][lost]") {
    EditedFile file(box(), ".step");
    const std::string first = file.find("CLOSED_SHELL\\('',\\((#[0-9]+),");
    file.edit("(CLOSED_SHELL\\('',\\()#[0-9]+,", "$01");
    const occ::ReadReport report = file.read();
    REQUIRE(report.lost.size() == 1);
    CHECK(report.lost[0].entity == first);
}

TEST_CASE("surfaces of a geometric set count as faces", "[occ][lost]") {
    EditedFile file(test::wing(), ".step");
    std::vector<std::string> surfaces;
    const std::regex kind("(#[0-9]+)=(B_SPLINE_SURFACE_WITH_KNOTS|BOUNDED_SURFACE)\\(");
    for (std::sregex_iterator it(file.text.begin(), file.text.end(), kind), end; it != end; ++it)
        surfaces.push_back((*it)[1]);
    REQUIRE(surfaces.size() >= 2);
    file.edit("ADVANCED_BREP_SHAPE", "GEOMETRICALLY_BOUNDED_SURFACE_SHAPE");
    file.edit("MANIFOLD_SOLID_BREP\\('',#[0-9]+\\)",
              "GEOMETRIC_SET('',(" + surfaces[0] + "," + surfaces[1] + "))");
    file.text =
        std::regex_replace(file.text, std::regex("#[0-9]+=(ADVANCED_FACE|CLOSED_SHELL)[^;]*;"), "");
    CHECK(file.read().lost.empty());
    file.edit(surfaces[1] + "=[^;]*;", surfaces[1] + "=FANCY_SURFACE(1.0);");
    const occ::ReadReport report = file.read();
    CHECK(report.faces_in_file == 1);
    REQUIRE(report.lost.size() == 1);
    CHECK(report.lost[0].entity == surfaces[1]);
    CHECK(report.lost[0].type == "FANCY_SURFACE");
}

TEST_CASE("a face of an IGES file is lost with its surface", "[occ][lost]") {
    EditedFile file(box(), ".igs");
    // The parameters of a face: surface (D7; D9 is its origin), number of loops, flag, loops.
    const std::string directory = file.find("\n510,7,1,1,[0-9]+; +0*([0-9]+)P");
    file.edit("\n510,7(,1,1,[0-9]+;)", "\n510,9$01");
    const occ::ReadReport report = file.read();
    REQUIRE(report.lost.size() == 1);
    CHECK(report.lost[0].entity == "D" + directory);
    CHECK(report.lost[0].type == "510 face");
}

TEST_CASE("instances of a STEP file are found by number", "[occ][lost]") {
    const auto found = occ::step_instances(
        "HEADER;\nDATA;\n#1 = A('it''s; #7', /* #8 = B(); */ "
        "#2);\n#2=(P(1)Q(#1,#3)R(('x')));#3=C();",
        {1, 2, 9});
    REQUIRE(found.size() == 2);
    CHECK(found.at(1) == "A('it''s; #7',#2)");
    CHECK(occ::step_references(found.at(1)) == std::vector<int>{2});
    CHECK(occ::step_references(found.at(2)) == std::vector<int>{1, 3});
    CHECK(occ::step_type(found.at(1)) == "A");
    CHECK(occ::step_type(found.at(2)) == "P+Q+R");
}
