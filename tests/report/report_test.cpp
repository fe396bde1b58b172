#include <patchwright/measure/deviation_statistics.h>
#include <patchwright/report/run_report.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using namespace patchwright;

namespace {

report::RunReport sample() {
    report::RunReport r;
    r.unit = base::LengthUnit::Inch;
    r.input =
        report::InputFigures{.file = "a<b>.igs", .format = "IGES", .faces = 3, .diagonal = 254.0};
    r.cage = mesh::CageSummary{.vertices = 8, .faces = 6};
    r.fit = report::FitFigures{.tolerance = 2.54, .levels = {{.vertices = 8, .max_mm = 1.27}}};
    r.patches = report::PatchFigures{.count = 24,
                                     .continuity = "g1",
                                     .covering = "charts",
                                     .caps = {{.faces = 3, .distance_mm = 2.54}}};
    r.solid = report::SolidFigures{
        .file = "o.step", .solids = 1, .closed = true, .volume = 25.4 * 25.4 * 25.4};
    r.deviation = report::DeviationFigures{
        .output_to_input = {
            .max = 25.4, .at = geom::Vec3(25.4, 0, -50.8), .face = 7, .samples = 10}};
    r.continuity = patch::Continuity{.max_kink_rad = M_PI / 180, .crease_edges = 12};
    r.seconds = {{"read", 1.0}, {"fit", 2.0}};
    return r;
}

}  // namespace

TEST_CASE("the JSON report has the contract's keys in the report's unit", "[report]") {
    const auto json = nlohmann::json::parse(report::to_json(sample()));
    CHECK(json.at("tool").at("name") == "patchwright");
    CHECK(json.at("unit") == "in");
    CHECK(json.at("input").at("diagonal").get<double>() == Approx(10.0));
    CHECK(json.at("fit").at("tolerance").get<double>() == Approx(0.1));
    CHECK(json.at("fit").at("levels").at(0).at("max").get<double>() == Approx(0.05));
    CHECK(json.at("solid").at("volume").get<double>() == Approx(1.0));
    CHECK(json.at("deviation").at("output_to_input").at("at").at(2).get<double>() == Approx(-2.0));
    CHECK(json.at("deviation").at("output_to_input").at("face") == 7);
    CHECK(json.at("continuity").at("max_kink_deg").get<double>() == Approx(1.0));
    CHECK(json.at("seconds").at("total").get<double>() == Approx(3.0));
    for (const char* key : {"count", "charts", "control_points", "caps", "continuity"}) {
        CHECK(json.at("patches").contains(key));
    }
    CHECK(json.at("patches").at("charts") == 24);
    CHECK(json.at("patches").at("caps") == 1);
    CHECK(json.at("patches").at("extraordinary").at(0).at("distance").get<double>() == Approx(0.1));
}

TEST_CASE("the verdict is the first and the last line, and in the JSON", "[report]") {
    report::RunReport r = sample();
    r.verdict =
        measure::assess({.tolerance_mm = 2.54,
                         .diagonal_mm = 254.0,
                         .output_to_input_mm = measure::Worst{25.4, geom::Vec3(25.4, 0, -50.8)},
                         .valid = true,
                         .kink_rad = measure::Worst{M_PI / 4, std::nullopt}});
    const std::string sentence = r.verdict->sentence(base::LengthUnit::Inch);
    const std::string text = report::to_text(r);
    CHECK(text.find(sentence + "\n") == 0);
    CHECK(text.rfind("\n" + sentence + "\n") == text.size() - sentence.size() - 2);
    CHECK(report::to_html(r).find("MISSED: ") != std::string::npos);

    const auto json = nlohmann::json::parse(report::to_json(r)).at("verdict");
    CHECK(json.at("met") == false);
    CHECK(json.at("sentence") == sentence);
    REQUIRE(json.at("conditions").size() == 3);
    const auto& distance = json.at("conditions").at(0);
    CHECK(distance.at("name") == "distance_to_input");
    CHECK(distance.at("value").get<double>() == Approx(1.0));
    CHECK(distance.at("limit").get<double>() == Approx(0.1));
    CHECK(distance.at("at").at(2).get<double>() == Approx(-2.0));
    CHECK(distance.at("met") == false);
    CHECK_FALSE(distance.at("remedy").get<std::string>().empty());
    CHECK(json.at("conditions").at(1).at("met") == true);
    CHECK(json.at("conditions").at(2).at("value").get<double>() == Approx(45.0));
    CHECK(json.at("conditions").at(2).at("at").is_null());
}

TEST_CASE("sections that do not apply are left out", "[report]") {
    const auto json = nlohmann::json::parse(report::to_json({}));
    for (const char* key : {"input", "fit", "deviation", "solid"}) CHECK_FALSE(json.contains(key));
    CHECK(report::to_text({}).empty());
}

TEST_CASE("HTML escapes what comes from files", "[report]") {
    const std::string page = report::to_html(sample());
    CHECK(page.find("a&lt;b&gt;.igs") != std::string::npos);
    CHECK(page.find("a<b>") == std::string::npos);
}

TEST_CASE("deviation statistics of known distances", "[fit][oracle]") {
    std::vector<measure::DistanceSample> samples;
    for (int i = 1; i <= 100; ++i) samples.push_back({geom::Vec3(i, 0, 0), i, double(i)});
    const measure::Deviation d = measure::deviation_statistics(samples);
    CHECK(d.max == 100.0);
    CHECK(d.face == 100);
    CHECK(d.at.x() == 100.0);
    CHECK(d.p95 == 95.0);
    CHECK(d.p99 == 99.0);
    CHECK(d.rms == Approx(std::sqrt(3383.5)));
    CHECK_FALSE(measure::deviation_statistics({}).face.has_value());
}
