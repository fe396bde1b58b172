#include "report/json_deviation.h"

#include <cmath>

namespace patchwright::report {

namespace {

constexpr double degrees_per_radian = 180.0 / M_PI;

/// Converts millimetres to the report's unit.
class DeviationWriter {
  public:
    explicit DeviationWriter(double scale) : scale_(scale) {}

    Json sharp_curves(const DeviationFigures& d) const {
        Json json = {{"input", d.sharp_curves_input}, {"output", d.sharp_curves_output}};
        if (d.sharp_output_to_input) json["output_to_input"] = deviation(*d.sharp_output_to_input);
        if (d.sharp_input_to_output) json["input_to_output"] = deviation(*d.sharp_input_to_output);
        if (d.long_sharp) {
            Json missed = Json::array();
            for (const auto& m : d.long_sharp->missed) {
                Json curve = {{"length", length(m.length)}, {"at", point(m.at)}};
                // No edge at all is no distance.
                curve["distance"] = std::isfinite(m.distance) ? length(m.distance) : Json();
                missed.push_back(curve);
            }
            json["long"] = {{"longer_than", length(d.long_sharp->longer_than)},
                            {"tolerance", length(d.long_sharp->tolerance)},
                            {"count", d.long_sharp->count},
                            {"missed", missed}};
        }
        return json;
    }
    Json fairness(const measure::RelativeFairness& f) const {
        return {{"samples", f.samples},
                {"left_out", f.left_out},
                {"unmatched", f.unmatched},
                {"normals_deg", distribution(f.normal_angle_rad, degrees_per_radian)},
                {"mean_curvature", distribution(f.curvature_difference, 1.0)},
                {"lines", f.lines},
                {"inflections", f.inflections},
                {"extra_inflections", f.extra_inflections}};
    }
    Json deviation(const measure::Deviation& d) const {
        Json json = {{"max", length(d.max)}, {"rms", length(d.rms)}, {"p50", length(d.p50)},
                     {"p95", length(d.p95)}, {"p99", length(d.p99)}, {"at", point(d.at)}};
        if (d.face) json["face"] = *d.face;
        json["samples"] = d.samples;
        if (d.bound) json["bound"] = length(*d.bound);
        for (const measure::DeviationPlace& place : d.worst) {
            json["worst"].push_back({{"distance", length(place.distance)},
                                     {"at", point(place.point)},
                                     {"face", place.face}});
        }
        if (d.faces.empty()) return json;
        json["faces"] = Json::array();
        for (const measure::DeviationOfFace& face : d.faces) {
            const auto angle = [](const std::optional<double>& rad) {
                return rad ? Json(*rad * degrees_per_radian) : Json();
            };
            json["faces"].push_back({{"face", face.face},
                                     {"samples", face.samples},
                                     {"max", length(face.max)},
                                     {"rms", length(face.rms)},
                                     {"normal_max_deg", angle(face.normal_max_rad)},
                                     {"normal_rms_deg", angle(face.normal_rms_rad)}});
        }
        json["histogram"] = {{"width", length(d.histogram.width)}, {"shares", d.histogram.shares}};
        return json;
    }

  private:
    Json length(double mm) const { return mm * scale_; }
    Json point(const geom::Vec3& p) const {
        return {p.x() * scale_, p.y() * scale_, p.z() * scale_};
    }
    Json distribution(const measure::Distribution& s, double factor) const {
        return {{"rms", s.rms * factor}, {"p50", s.p50 * factor}, {"p95", s.p95 * factor},
                {"p99", s.p99 * factor}, {"max", s.max * factor}, {"at", point(s.at)}};
    }

    double scale_;
};

}  // namespace

Json deviation_json(const DeviationFigures& figures, double scale) {
    const DeviationWriter writer(scale);
    return {{"output_to_input", writer.deviation(figures.output_to_input)},
            {"input_to_output", writer.deviation(figures.input_to_output)}};
}

Json fairness_json(const measure::RelativeFairness& figures, double scale) {
    return DeviationWriter(scale).fairness(figures);
}

Json sharp_curves_json(const DeviationFigures& figures, double scale) {
    return DeviationWriter(scale).sharp_curves(figures);
}

}  // namespace patchwright::report
