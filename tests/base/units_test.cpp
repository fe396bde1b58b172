#include <patchwright/base/error.h>
#include <patchwright/base/units.h>

#include <catch2/catch.hpp>

using namespace patchwright;

TEST_CASE("lengths with units are read", "[base]") {
    CHECK(base::parse_length("0.05mm").in_millimetres(1.0) == Approx(0.05));
    CHECK(base::parse_length("0.002in").in_millimetres(1.0) == Approx(0.0508));
    CHECK(base::parse_length("1e-4rel").in_millimetres(2000.0) == Approx(0.2));
    CHECK(base::parse_length("3cm").in_millimetres(1.0) == Approx(30.0));
    CHECK(base::parse_length("0.1 mm").in_millimetres(1.0) == Approx(0.1));
    CHECK(base::parse_length("1e-4 rel").in_millimetres(2000.0) == Approx(0.2));
    CHECK(base::parse_length("1 inch").in_millimetres(1.0) == Approx(25.4));
    CHECK(base::parse_length("2ft").in_millimetres(1.0) == Approx(609.6));
}

TEST_CASE("angles with units are read", "[base]") {
    CHECK(base::parse_angle("180deg") == Approx(M_PI));
    CHECK(base::parse_angle("0.01 rad") == Approx(0.01));
    for (const char* text : {"", "deg", "0deg", "-1deg", "1", "1mm", "nandeg", "1 deg "}) {
        CAPTURE(text);
        CHECK_THROWS_AS(base::parse_angle(text), base::InvalidArgument);
    }
}

TEST_CASE("a unit is known by its size", "[base]") {
    using base::LengthUnit;
    CHECK(base::likely_unit(25.0) == LengthUnit::Inch);
    CHECK(base::likely_unit(320.0) == LengthUnit::Foot);
    CHECK(base::likely_unit(1.9) == LengthUnit::Millimetre);
    CHECK_FALSE(base::likely_unit(2.1).has_value());
    CHECK_FALSE(base::likely_unit(1e6).has_value());
}

TEST_CASE("what is no length is refused", "[base]") {
    for (const char* text :
         {"", "mm", "0mm", "-1mm", "1", "1furlong", "nanmm", "infmm", "1 ", "1mm "}) {
        CAPTURE(text);
        CHECK_THROWS_AS(base::parse_length(text), base::InvalidArgument);
    }
}
