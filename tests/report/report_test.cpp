#include "report/thin_field.h"

#include <patchwright/measure/deviation_statistics.h>
#include <patchwright/report/run_report.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>

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

TEST_CASE("a field is thinned to what is asked for, and keeps its shape and its worst vertex",
          "[report]") {
    constexpr int n = 60;  // squares along a side of 1 mm each
    measure::Field field;
    field.points.resize((n + 1) * (n + 1), 3);
    field.normals.resize(field.points.rows(), 3);
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) {
            const int v = i * (n + 1) + j;
            field.points.row(v) = geom::Vec3(i, j, 0.0);
            field.normals.row(v) = geom::Vec3::UnitZ();
            field.distance_mm.push_back(i == 17 && j == 41 ? 5.0 : 0.1);
            field.normal_angle_rad.push_back(0.0);
            field.curvature.push_back(0.0);
            field.other_curvature.push_back(0.0);
            if (i == n || j == n) continue;
            field.triangles.push_back({v, v + n + 1, v + 1});
            field.triangles.push_back({v + 1, v + n + 1, v + n + 2});
            field.faces.insert(field.faces.end(), 2, 0);
        }
    }
    const measure::Field same = report::thin_field(field, int(field.points.rows()));
    CHECK(same.points == field.points);
    CHECK(same.triangles == field.triangles);

    constexpr int most = 400;
    const measure::Field thin = report::thin_field(field, most);
    CHECK(thin.points.rows() <= most);
    CHECK(thin.points.rows() > most / 4);
    REQUIRE(thin.distance_mm.size() == std::size_t(thin.points.rows()));
    const auto worst = std::max_element(thin.distance_mm.begin(), thin.distance_mm.end());
    CHECK(*worst == 5.0);
    CHECK(thin.points.row(worst - thin.distance_mm.begin()) == Eigen::RowVector3d(17, 41, 0));
    double area = 0.0;
    for (const auto& [a, b, c] : thin.triangles) {
        const Eigen::RowVector3d u = thin.points.row(b) - thin.points.row(a),
                                 v = thin.points.row(c) - thin.points.row(a);
        area += 0.5 * (u.x() * v.y() - u.y() * v.x());
    }
    CHECK(area == Approx(double(n * n)).epsilon(0.15));  // less a strip along the border
}
