#include "measure/crease_distance.h"
#include "measure/parameter_lines.h"
#include "measure/progress_loop.h"

#include <patchwright/base/error.h>
#include <patchwright/measure/relative_fairness.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace patchwright::measure {

namespace {

using geom::Vec3;

/// Of the diagonal: points nearer to edges of the input are left out, those farther from the input
/// have no counterpart on it.
constexpr double beside_edge_rel = 2e-3, reach_rel = 2e-2;
/// Edges of the input whose faces meet at more are no smooth ones: 3 degrees.
constexpr double least_crease_rad = 0.0523598775598299;
/// Between points along lines, of the diagonal.
constexpr double line_step_rel = 1e-3;
/// A run of points along a line that is shorter says nothing.
constexpr std::size_t shortest_run = 16;
/// Turns between two inflections are larger: 0.05 degrees.
constexpr double least_turn_rad = 8.72664625997165e-4;

double mean(const geom::Curvature& c) { return 0.5 * (c.value[0] + c.value[1]); }

/// Normal curvature in a unit direction, by Euler.
double along(const geom::Curvature& c, const Vec3& direction) {
    double sum = 0.0;
    for (std::size_t k = 0; k < 2; ++k)
        sum += c.value[k] * std::pow(direction.dot(c.direction[k]), 2);
    return sum;
}

/// A point of the output and its counterpart on the input. Curvatures of both are by the output's
/// normal.
struct MatchedPoint {
    Vec3 point;
    double normal_angle_rad;
    geom::Curvature of_output, of_input;
};

enum class MatchFailure { BesideEdge, Unmatched };

/// Either a match or the reason for none.
struct Match {
    std::optional<MatchedPoint> found;
    MatchFailure failure = MatchFailure::Unmatched;
};

class Matcher {
  public:
    Matcher(const geom::ModelSurface& output, const geom::ModelSurface& input)
        : output_(output),
          input_(input),
          creases_(input, least_crease_rad),
          diagonal_(input.bounds().diagonal()) {}

    [[nodiscard]] double diagonal() const { return diagonal_; }

    [[nodiscard]] Match match(const geom::FootPoint& on_output) const {
        if (on_output.normal.isZero(0.0)) return {};
        const auto of_output = output_.curvature(on_output);
        if (!of_output) return {};
        if (creases_.is_within(on_output.point, beside_edge_rel * diagonal_))
            return {std::nullopt, MatchFailure::BesideEdge};
        const geom::FootPoint foot = input_.foot_point(on_output.point, on_output.normal);
        if (foot.face < 0 || foot.normal.isZero(0.0) || foot.distance > reach_rel * diagonal_)
            return {};
        auto of_input = input_.curvature(foot);
        if (!of_input) return {};
        const double cosine = foot.normal.dot(on_output.normal);
        // An open model may be given with its other side outward.
        const Vec3 normal = cosine < 0.0 ? Vec3(-foot.normal) : foot.normal;
        if (cosine < 0.0)
            for (double& value : of_input->value) value = -value;
        const double angle = std::atan2(normal.cross(on_output.normal).norm(), std::abs(cosine));
        return {MatchedPoint{on_output.point, angle, *of_output, *of_input}};
    }

  private:
    const geom::ModelSurface &output_, &input_;
    CreaseDistance creases_;
    double diagonal_;
};

struct PlacedValue {
    double value;
    Vec3 at;
};

Distribution distribution_of(std::vector<PlacedValue> values) {
    Distribution result;
    if (values.empty()) return result;
    std::stable_sort(values.begin(), values.end(),
                     [](const auto& a, const auto& b) { return a.value < b.value; });
    const auto quantile = [&](double share) {
        return values[std::size_t(std::ceil(share * double(values.size()))) - 1].value;
    };
    double squares = 0.0;
    for (const PlacedValue& v : values) squares += v.value * v.value;
    result.rms = std::sqrt(squares / double(values.size()));
    result.p50 = quantile(0.50);
    result.p95 = quantile(0.95);
    result.p99 = quantile(0.99);
    result.max = values.back().value;
    result.at = values.back().at;
    return result;
}

/// How often a sequence turns back after it has changed by more than `least`.
int turning_points(const std::vector<double>& values, double least) {
    int count = 0, direction = 0;
    double low = values.front(), high = values.front();
    for (const double v : values) {
        if (direction >= 0) {
            high = std::max(high, v);
            if (v < high - least) {
                count += direction > 0;
                direction = -1;
                low = v;
            }
        }
        if (direction <= 0) {
            low = std::min(low, v);
            if (v > low + least) {
                count += direction < 0;
                direction = 1;
                high = v;
            }
        }
    }
    return count;
}

struct LineInflections {
    int of_input = 0, of_output = 0;
};

/// Along one line: the integrals of both normal curvatures, run by run.
class LineWalk {
  public:
    explicit LineWalk(const Matcher& matcher) : matcher_(matcher) {}

    LineInflections along_line(const std::vector<geom::FootPoint>& points) {
        for (std::size_t i = 0; i + 1 < points.size(); ++i) {
            const Vec3 step = points[i + 1].point - points[i].point;
            const auto match = matcher_.match(points[i]).found;
            const Vec3 direction = step.normalized();
            if (!match || !(direction.norm() > 0.5)) {
                end_run();
                continue;
            }
            const double length = step.norm();
            output_.push_back(last(output_) + length * along(match->of_output, direction));
            input_.push_back(last(input_) + length * along(match->of_input, direction));
        }
        end_run();
        return result_;
    }

  private:
    static double last(const std::vector<double>& turns) {
        return turns.empty() ? 0.0 : turns.back();
    }
    void end_run() {
        if (output_.size() >= shortest_run) {
            result_.of_output += turning_points(output_, least_turn_rad);
            result_.of_input += turning_points(input_, least_turn_rad);
        }
        output_.clear();
        input_.clear();
    }

    const Matcher& matcher_;
    std::vector<double> output_, input_;  ///< turns in radians up to each point
    LineInflections result_;
};

void measure_samples(const geom::ModelSurface& output, const Matcher& matcher,
                     const RelativeFairnessOptions& options, RelativeFairness& result) {
    const std::vector<SurfacePlace> places = places_by_area(output, options.samples);
    std::vector<Match> matches(places.size());
    loop_with_progress(
        0, places.size(), 8192, 128, "fairness", options.progress, [&](std::size_t i) {
            matches[i] = matcher.match(output.point_on_face(places[i].face, places[i].uv));
        });
    std::vector<PlacedValue> angles, differences;
    for (const Match& match : matches) {
        if (!match.found) {
            ++(match.failure == MatchFailure::BesideEdge ? result.left_out : result.unmatched);
            continue;
        }
        ++result.samples;
        const MatchedPoint& m = *match.found;
        angles.push_back({m.normal_angle_rad, m.point});
        differences.push_back(
            {matcher.diagonal() * std::abs(mean(m.of_output) - mean(m.of_input)), m.point});
    }
    result.normal_angle_rad = distribution_of(std::move(angles));
    result.curvature_difference = distribution_of(std::move(differences));
}

}  // namespace

RelativeFairness measure_relative_fairness(const geom::ModelSurface& output,
                                           const geom::ModelSurface& input,
                                           const RelativeFairnessOptions& options) {
    if (options.samples < 1 || options.lines < 0)
        throw base::InvalidArgument(
            fmt::format("fairness: {} samples and {} lines", options.samples, options.lines));
    const Matcher matcher(output, input);
    RelativeFairness result;
    measure_samples(output, matcher, options, result);
    const std::vector<ParameterLine> lines =
        parameter_lines(output, options.lines, line_step_rel * matcher.diagonal());
    std::vector<LineInflections> found(lines.size());
    loop_with_progress(0, lines.size(), 64, 1, "fairness", options.progress, [&](std::size_t i) {
        found[i] = LineWalk(matcher).along_line(points_on(output, lines[i]));
    });
    result.lines = int(lines.size());
    for (const LineInflections& line : found) {
        result.inflections += line.of_input;
        result.extra_inflections += line.of_output - line.of_input;
    }
    base::report_progress(options.progress, "fairness", 1.0);
    return result;
}

}  // namespace patchwright::measure
