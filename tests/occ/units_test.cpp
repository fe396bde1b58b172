// Units and the kernel's process-wide state: the same wing from files in several units, and
// parameters that are as they were after every call.
#include "occ/exchange/exchange_session.h"
#include "occ/shapes.h"

#include <patchwright/base/error.h>
#include <patchwright/occ/inspect.h>

#include <IGESControl_Controller.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Controller.hxx>
#include <TColStd_HSequenceOfHAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <map>

using namespace patchwright;
using base::LengthUnit;
using geom::Vec3;

namespace {

std::filesystem::path scratch(const std::string& name) {
    const auto folder = std::filesystem::temp_directory_path() / "patchwright_units";
    std::filesystem::create_directories(folder);
    return folder / name;
}

/// Every parameter of the kernel's data exchange with its value.
std::map<std::string, std::string> kernel_parameters() {
    STEPControl_Controller::Init();
    IGESControl_Controller::Init();
    std::map<std::string, std::string> result;
    const auto names = Interface_Static::Items();
    for (int i = 1; i <= names->Length(); ++i) {
        const char* name = names->Value(i)->ToCString();
        const char* value = Interface_Static::CVal(name);
        result[name] = value != nullptr ? value : "";
    }
    return result;
}

}  // namespace

TEST_CASE("one wing in files of four units is one wing", "[occ][units][oracle]") {
    const occ::CadModel wing = test::model_of(test::wing());
    const occ::Inspection expected = occ::inspect(wing);
    const occ::CadReference original(wing);
    const double size = expected.bounds.diagonal();
    for (const char* suffix : {"step", "igs"}) {
        for (const LengthUnit unit :
             {LengthUnit::Millimetre, LengthUnit::Metre, LengthUnit::Inch, LengthUnit::Foot}) {
            const auto file = scratch(std::string(base::short_name(unit)) + "." + suffix);
            CAPTURE(file.string());
            occ::write_cad(wing, file, {.unit = unit});
            const occ::ReadResult read = occ::read_cad(file);
            CHECK(read.report.unit == unit);
            const occ::Inspection found = occ::inspect(read.model);
            CHECK((found.bounds.min - expected.bounds.min).norm() < 1e-9 * size);
            CHECK((found.bounds.max - expected.bounds.max).norm() < 1e-9 * size);
            // IGES has edges without parameters on their faces; the kernel makes them anew, and
            // what it integrates over ends at them.
            const double integral = std::string(suffix) == "step" ? 1e-9 : 1e-8;
            CHECK(found.area_mm2 == Approx(expected.area_mm2).epsilon(integral));
            CHECK(found.volume_mm3 == Approx(expected.volume_mm3).epsilon(integral));
            const occ::CadReference reference(read.model);
            for (int i = 0; i < 50; ++i) {
                const Vec3 query(2.0 * i, 30.0 - i, 6.0 * i);
                CHECK(reference.foot_point(query).distance ==
                      Approx(original.foot_point(query).distance).margin(1e-9 * size));
            }
        }
    }
}

TEST_CASE("no call leaves the kernel's parameters changed", "[occ][units]") {
    // As another user of the kernel in the same process may have set them.
    STEPControl_Controller::Init();
    IGESControl_Controller::Init();
    const std::string saved_unit = Interface_Static::CVal("write.step.unit");
    const std::string saved_internal = Interface_Static::CVal("xstep.cascade.unit");
    Interface_Static::SetCVal("write.step.unit", "FT");
    Interface_Static::SetCVal("xstep.cascade.unit", "INCH");
    const auto before = kernel_parameters();
    CHECK(before.size() > 20);

    const occ::CadModel wing = test::model_of(test::wing());
    for (const char* name : {"statics.step", "statics.igs", "statics.brep"}) {
        CAPTURE(name);
        occ::write_cad(wing, scratch(name), {.unit = LengthUnit::Inch});
        CHECK(kernel_parameters() == before);
        const occ::ReadResult read = occ::read_cad(scratch(name), {.unit = LengthUnit::Metre});
        CHECK(kernel_parameters() == before);
        occ::inspect(read.model);
        const occ::CadReference reference(read.model);
        CHECK(reference.foot_point(Vec3(1, 2, 3)).face >= 0);
        CHECK(kernel_parameters() == before);
    }
    // Nor do failures.
    std::ofstream(scratch("broken.step")) << "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n"
                                             "#1=NONSENSE(;\nENDSEC;\nEND-ISO-10303-21;\n";
    CHECK_THROWS_AS(occ::read_cad(scratch("broken.step")), base::InputError);
    CHECK(kernel_parameters() == before);
    CHECK_THROWS_AS(occ::write_cad(wing, scratch("no_such_folder") / "sub" / "a.step"),
                    base::OutputError);
    CHECK(kernel_parameters() == before);
    // What files hold does not depend on them either.
    const occ::Inspection found = occ::inspect(occ::read_cad(scratch("statics.step")).model);
    CHECK(found.volume_mm3 == Approx(occ::inspect(wing).volume_mm3).epsilon(1e-9));

    Interface_Static::SetCVal("write.step.unit", saved_unit.c_str());
    Interface_Static::SetCVal("xstep.cascade.unit", saved_internal.c_str());
}
