#include "occ/exchange/cad_model_impl.h"
#include "occ/exchange/step_text.h"
#include "support/cages.h"

#include <patchwright/occ/assemble.h>
#include <patchwright/occ/inspect.h>
#include <patchwright/patch/extract.h>

#include <BRep_Tool.hxx>
#include <STEPConstruct_Styles.hxx>
#include <STEPConstruct_ValidationProps.hxx>
#include <STEPControl_Reader.hxx>
#include <StepRepr_PropertyDefinitionRepresentation.hxx>
#include <StepRepr_Representation.hxx>
#include <TColStd_SequenceOfTransient.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <XSControl_WorkSession.hxx>
#include <catch2/catch.hpp>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

using namespace patchwright;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

/// A file name in the temporary folder; the file is removed at the end.
class TemporaryName {
  public:
    explicit TemporaryName(const std::string& name)
        : path_(fs::temp_directory_path() / (std::to_string(::getpid()) + name)) {}
    ~TemporaryName() { fs::remove(path_); }
    [[nodiscard]] const fs::path& path() const { return path_; }
    [[nodiscard]] std::string text() const {
        std::ifstream stream(path_, std::ios::binary);
        std::stringstream text;
        text << stream.rdbuf();
        return text.str();
    }

  private:
    fs::path path_;
};

patch::PatchSet cube_patches() { return patch::extract(test::cube(40.0)).patches; }

}  // namespace

TEST_CASE("names beyond ASCII are written as Part 21 asks for", "[occ]") {
    CHECK(occ::encode_step_text("wing's \\\\ tip") == "wing's \\\\ tip");
    CHECK(occ::encode_step_text("Fl\u00fcgel") == "Fl\\X2\\00FC\\X0\\gel");
    CHECK(occ::encode_step_text("\u7ffc\U0001F6E9") == "\\X2\\7FFC\\X0\\\\X4\\0001F6E9\\X0\\");
    CHECK(occ::encode_step_text("\xe4\xe9 \xc3") ==  // not UTF-8
          "\\X2\\00E4\\X0\\\\X2\\00E9\\X0\\ \\X2\\00C3\\X0\\");
    const TemporaryName file("Fl\u00fcgel.step");
    occ::write_cad(occ::assemble(cube_patches()), file.path());
    const std::string text = file.text();
    CHECK(std::all_of(text.begin(), text.end(), [](char c) { return c > 0; }));
    CHECK(occ::inspect(occ::read_cad(file.path()).model).solids == 1);
}

TEST_CASE("the smooth cube takes 6 faces and 40 kB", "[occ]") {
    const TemporaryName file("cube.step");
    occ::write_cad(occ::assemble(patch::extract(test::cube(50.0), {.tolerance_mm = 1e-2}).patches),
                   file.path());
    CHECK(fs::file_size(file.path()) <= 40000);
    CHECK(occ::inspect(occ::read_cad(file.path()).model).faces == 6);
}

TEST_CASE("colours of faces are in the file, each once", "[occ]") {
    patch::PatchSet set = cube_patches();
    set.patches[0].colour = patch::Colour{1.0, 0.0, 0.0};
    set.patches[1].colour = patch::Colour{0.2, 0.4, 0.6};
    set.patches[2].colour = patch::Colour{0.2, 0.4, 0.6};
    const TemporaryName file("colours.step");
    occ::write_cad(occ::assemble(set), file.path());
    STEPControl_Reader reader;
    REQUIRE(reader.ReadFile(file.path().c_str()) == IFSelect_RetDone);
    reader.TransferRoots();
    STEPConstruct_Styles styles(reader.WS());
    REQUIRE(styles.LoadStyles());
    CHECK(styles.NbStyles() == 3);
    const std::string text = file.text();
    std::size_t colours = 0;
    for (auto at = text.find("COLOUR"); at != std::string::npos; at = text.find("COLOUR", at + 1)) {
        colours += text.compare(at, 11, "COLOUR_RGB(") == 0 ? 1 : 0;
    }
    CHECK(colours <= 2);
    const TemporaryName plain("plain.step");
    occ::write_cad(occ::assemble(cube_patches()), plain.path());
    CHECK_THAT(plain.text(), !Contains("STYLED_ITEM"));
}

TEST_CASE("AP242 files hold area, volume and centroid of what is in them", "[occ][oracle]") {
    const TemporaryName file("properties.step");
    mesh::Cage cage = test::cube(40.0);
    cage.points.rowwise() += Eigen::RowVector3d(5, -7, 11);
    const occ::CadModel model = occ::assemble(patch::extract(cage).patches);
    occ::write_cad(model, file.path(), {.schema = occ::StepSchema::Ap242});
    STEPControl_Reader reader;
    REQUIRE(reader.ReadFile(file.path().c_str()) == IFSelect_RetDone);
    reader.TransferRoots();
    STEPConstruct_ValidationProps properties(reader.WS());
    TColStd_SequenceOfTransient all;
    REQUIRE(properties.LoadProps(all));
    double area = 0.0, volume = 0.0;
    gp_Pnt centroid;
    for (int k = 1; k <= all.Length(); ++k) {
        const auto definition = Handle(StepRepr_PropertyDefinitionRepresentation)::DownCast(all(k));
        const auto representation = definition->UsedRepresentation();
        for (int i = 1; i <= representation->NbItems(); ++i) {
            double value = 0.0;
            bool is_area = false;
            if (properties.GetPropReal(representation->ItemsValue(i), value, is_area)) {
                (is_area ? area : volume) = value;
            } else {
                properties.GetPropPnt(representation->ItemsValue(i),
                                      representation->ContextOfItems(), centroid);
            }
        }
    }
    const occ::Inspection i = occ::inspect(occ::read_cad(file.path()).model);
    CHECK(area == Approx(i.area_mm2).epsilon(1e-9));
    CHECK(volume == Approx(i.volume_mm3).epsilon(1e-9));
    CHECK(centroid.Distance(gp_Pnt(5, -7, 11)) < 1e-6);
}

TEST_CASE("a time stamp is written when asked for only", "[occ]") {
    const occ::CadModel model = occ::assemble(cube_patches());
    for (const char* name : {"time.step", "time.igs"}) {
        const TemporaryName file(name);
        occ::write_cad(model, file.path());
        CHECK_THAT(file.text(), Contains("1970"));
        occ::write_cad(model, file.path(), {.time_stamp = true});
        CHECK_THAT(file.text(), !Contains("1970"));
    }
}

TEST_CASE("a STEP text is compacted without a change of meaning", "[occ]") {
    const std::string text =
        "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1 = A('it''s; #4 ''x''',(#2,\n    #3),#10);\n"
        "#2 = CARTESIAN_POINT('',(1.,2.,\n  3.));\n#3 = CARTESIAN_POINT('',(1.,2.,3.));\n"
        "#10 = ( B() C(#3) );\nENDSEC;\nEND-ISO-10303-21;\n";
    CHECK(occ::compact_step(text) ==
          "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=A('it''s; #4 ''x''',(#2,#2),#3);\n"
          "#2=CARTESIAN_POINT('',(1.,2.,3.));\n#3=(B()C(#2));\nENDSEC;\nEND-ISO-10303-21;\n");
}

TEST_CASE("smooth edges are marked by how smooth they are", "[occ]") {
    const auto marks = [](const mesh::Cage& cage) {
        std::map<GeomAbs_Shape, int> count;
        const occ::CadModel model =
            occ::assemble(patch::extract(cage, {.covering = patch::Covering::Faces}).patches);
        TopTools_IndexedDataMapOfShapeListOfShape faces;
        TopExp::MapShapesAndAncestors(model.impl().shape, TopAbs_EDGE, TopAbs_FACE, faces);
        for (int k = 1; k <= faces.Extent(); ++k) {
            if (faces(k).Extent() != 2) continue;
            ++count[BRep_Tool::Continuity(TopoDS::Edge(faces.FindKey(k)),
                                          TopoDS::Face(faces(k).First()),
                                          TopoDS::Face(faces(k).Last()))];
        }
        return count;
    };
    CHECK(marks(test::torus(6, 6, 3, 1)) == std::map<GeomAbs_Shape, int>{{GeomAbs_C2, 72}});
    CHECK(marks(test::cube(2.0)) == std::map<GeomAbs_Shape, int>{{GeomAbs_G1, 12}});
    mesh::TopologyInput tags;
    tags.creases.push_back({0, 1, mesh::infinite_sharpness});
    CHECK(marks(test::cube(2.0, tags))[GeomAbs_C0] == 1);
}

TEST_CASE("a closed part inside another is its void", "[occ][oracle]") {
    const auto nested = [](const std::vector<double>& edges) {
        std::vector<geom::Vec3> points;
        std::vector<std::vector<int>> faces;
        for (const double edge : edges) {
            const int first = int(points.size());
            for (int i = 0; i < 8; ++i) {
                points.push_back(
                    0.5 * edge *
                    geom::Vec3(2 * (i & 1) - 1, 2 * (i >> 1 & 1) - 1, 2 * (i >> 2) - 1));
            }
            for (std::vector<int> face : test::cube_faces) {
                for (int& v : face) v += first;
                faces.push_back(face);
            }
        }
        return occ::assemble(patch::extract(test::make_cage(points, faces)).patches);
    };
    const double unit = occ::inspect(nested({1.0})).volume_mm3;
    const TemporaryName file("void.step");
    occ::write_cad(nested({4.0, 8.0}), file.path());
    const occ::Inspection hollow = occ::inspect(occ::read_cad(file.path()).model);
    CHECK(hollow.solids == 1);
    CHECK(hollow.shells_closed == 2);
    CHECK(hollow.valid);
    // Caps differ by their tolerance, which is a share of the whole model.
    CHECK(hollow.volume_mm3 == Approx(unit * (512 - 64)).epsilon(1e-3));
    const occ::Inspection core = occ::inspect(nested({2.0, 4.0, 8.0}));
    CHECK(core.solids == 2);
    CHECK(core.volume_mm3 == Approx(unit * (512 - 64 + 8)).epsilon(1e-3));
}
