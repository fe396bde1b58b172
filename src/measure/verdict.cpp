#include <patchwright/base/error.h>
#include <patchwright/measure/verdict.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace patchwright::measure {

namespace {

constexpr double degrees = 180.0 / M_PI;

/// 0.000052 as "5.2e-5", 0.0001 as "1e-4".
std::string short_number(double value) {
    const std::string text = fmt::format("{:.1e}", value);  // d.de-dd
    const std::string digits = text[2] == '0' ? text.substr(0, 1) : text.substr(0, 3);
    return digits + "e" + std::to_string(std::stoi(text.substr(text.find('e') + 1)));
}

std::string plural(int count, const char* one, const char* many) {
    return count == 1 ? fmt::format("one {}", one) : fmt::format("{} {}", count, many);
}

/// Conditions in the order of Requirement.
class Assessment {
  public:
    explicit Assessment(const VerdictFigures& figures) : f_(figures) {
        if ((f_.output_to_input_mm || f_.input_to_output_mm) && !f_.tolerance_mm)
            throw base::InvalidArgument("verdict: distances need a tolerance");
        if (f_.volume_mm3 && !f_.area_mm2)
            throw base::InvalidArgument("verdict: a volume needs the area");
    }

    std::vector<Condition> conditions() {
        distance(Requirement::DistanceToInput, f_.output_to_input_mm);
        distance(Requirement::DistanceFromInput, f_.input_to_output_mm);
        failures(Requirement::SharpCurves, f_.lost_sharp_curves,
                 of_cage("a smaller --tolerance, or a cage with creases along these curves "
                         "(--cage)"));
        if (f_.free_edges)
            failures(Requirement::Closed, Failures{*f_.free_edges, std::nullopt},
                     of_cage("healing the input, or a closed cage (--cage)"));
        if (f_.valid)
            failures(Requirement::Valid, Failures{*f_.valid ? 0 : 1, std::nullopt},
                     of_cage("another cage (--target-faces, --layout, --cage)"));
        bodies();
        extent();
        angle(Requirement::Folds, f_.fold_rad, fold_limit_rad,
              of_cage("more faces there (--target-faces), or a cage without folds (--cage)"));
        if (f_.normal_tolerance_rad)
            angle(Requirement::Normals, f_.normal_angle_rad, *f_.normal_tolerance_rad,
                  of_cage("a smaller --tolerance, or more faces there (--target-faces, --cage)"));
        angle(Requirement::Kinks, f_.kink_rad, kink_limit_rad,
              of_cage("more faces there (--target-faces), or a crease along this edge (--cage)"));
        failures(Requirement::SelfIntersections, f_.self_intersecting_faces,
                 of_cage("more faces there (--target-faces), or another cage (--cage)"));
        failures(Requirement::GridCells, f_.bad_grid_cells,
                 "smaller cells or thinner layers, or a cage without folds");
        failures(Requirement::Designs, f_.missed_designs,
                 std::string(f_.stopped_by_time_limit ? "a longer --time-limit, or " : "") +
                     "a coarser --tolerance, or these designs one by one (refit)");
        return std::move(conditions_);
    }

  private:
    /// What is to be changed in the cage.
    [[nodiscard]] std::string of_cage(const char* change) const {
        return f_.keeps_cage ? "a new cage for this model (convert)" : change;
    }
    void add(Requirement requirement, Quantity quantity, const Worst& worst, double limit, bool met,
             const std::string& remedy) {
        conditions_.push_back({requirement, quantity, worst.value, limit, met, worst.at,
                               met ? std::string() : remedy});
    }
    void distance(Requirement requirement, const std::optional<Worst>& worst) {
        if (!worst) return;
        const bool met = worst->value <= *f_.tolerance_mm;
        std::string remedy = f_.stopped_by_time_limit ? "a longer --time-limit, or " : "";
        remedy += fmt::format("--tolerance {:.1g}rel, or {}",
                              1.1 * worst->value / std::max(f_.diagonal_mm, 1e-300),
                              of_cage("a finer cage (--target-faces, --cage)"));
        add(requirement, Quantity::Length, *worst, *f_.tolerance_mm, met, remedy);
    }
    void failures(Requirement requirement, const std::optional<Failures>& found,
                  const std::string& remedy) {
        if (found)
            add(requirement, Quantity::Count, {double(found->count), found->at}, 0.0,
                found->count == 0, remedy);
    }
    void angle(Requirement requirement, const std::optional<Worst>& worst, double limit,
               const std::string& remedy) {
        if (worst) add(requirement, Quantity::Angle, *worst, limit, worst->value <= limit, remedy);
    }
    void bodies() {
        if (f_.bodies && f_.bodies_of_input)
            add(Requirement::Bodies, Quantity::Count, {double(*f_.bodies), std::nullopt},
                double(*f_.bodies_of_input), *f_.bodies == *f_.bodies_of_input,
                of_cage("a cage with as many parts as the model has bodies (--cage)"));
    }

    void extent() {
        if (f_.volume_mm3) {
            const double film = film_volume(*f_.area_mm2);
            add(Requirement::Volume, Quantity::Volume, {*f_.volume_mm3, std::nullopt}, film,
                *f_.volume_mm3 > film, "a cage that encloses a volume");
        } else if (f_.area_mm2) {
            const double thread = least_thickness_mm * f_.diagonal_mm;
            add(Requirement::Area, Quantity::Area, {*f_.area_mm2, std::nullopt}, thread,
                *f_.area_mm2 > thread, "a cage whose faces have an area");
        }
    }

    const VerdictFigures& f_;
    std::vector<Condition> conditions_;
};

std::string describe_shape(const VerdictFigures& f) {
    if (f.is_grid) return "grid without folded cells";
    if (f.designs) return plural(*f.designs, "design", "designs");
    std::string text;
    if (f.bodies) {
        const char* state = f.closed ? "closed" : "open";
        const char* valid = !f.valid ? "" : *f.valid ? " valid" : " invalid";
        const std::string one = fmt::format("{}{} {}", state, valid, f.closed ? "solid" : "shell");
        text = plural(*f.bodies, one.c_str(), (one + "s").c_str());
    }
    if (f.patches) text += (text.empty() ? "" : ", ") + plural(*f.patches, "patch", "patches");
    return text;
}

/// What is wrong, in words.
std::string describe(const Condition& c, std::optional<double> tolerance_rel) {
    const int count = int(std::min(c.value, 1e9));
    switch (c.requirement) {
        case Requirement::DistanceToInput:
        case Requirement::DistanceFromInput: {
            const bool to = c.requirement == Requirement::DistanceToInput;
            const double relative = *tolerance_rel * c.value / c.limit;
            return fmt::format("{} {} of the diagonal from {} (limit {})",
                               to ? "the output is" : "the input is", short_number(relative),
                               to ? "the input" : "the output", short_number(*tolerance_rel));
        }
        case Requirement::SharpCurves:
            return plural(count, "long sharp curve is lost", "long sharp curves are lost");
        case Requirement::Closed:
            return plural(count, "free edge in a closed model", "free edges in a closed model");
        case Requirement::Valid: return "the shape is not valid for the CAD kernel";
        case Requirement::Bodies:
            return fmt::format("{} where the input has {:.0f}", plural(count, "body", "bodies"),
                               c.limit);
        case Requirement::Volume: return fmt::format("the volume is {:.3g} mm^3", c.value);
        case Requirement::Area: return fmt::format("the area is {:.3g} mm^2", c.value);
        case Requirement::Folds:
            return fmt::format("a fold: normals differ by {:.0f} degrees", c.value * degrees);
        case Requirement::Normals:
            return fmt::format("normals differ by {:.3g} degrees (limit {:.3g})", c.value * degrees,
                               c.limit * degrees);
        case Requirement::Kinks:
            return fmt::format("a kink of {:.3g} degrees across an edge meant to be smooth",
                               c.value * degrees);
        case Requirement::SelfIntersections:
            return plural(count, "face intersects itself",
                          "faces intersect themselves or each other");
        case Requirement::GridCells:
            return plural(count, "folded or negative cell", "folded or negative cells");
        case Requirement::Designs: return plural(count, "design misses", "designs miss");
    }
    return {};
}

}  // namespace

// A film has its area on both sides.
double film_volume(double area_mm2) { return 0.5 * least_thickness_mm * area_mm2; }

const char* name_of(Requirement requirement) {
    constexpr const char* names[] = {"distance_to_input",
                                     "distance_from_input",
                                     "sharp_curves",
                                     "closed",
                                     "valid",
                                     "bodies",
                                     "volume",
                                     "area",
                                     "folds",
                                     "normals",
                                     "kinks",
                                     "self_intersections",
                                     "grid_cells",
                                     "designs"};
    return names[static_cast<std::size_t>(requirement)];
}

double excess(const Condition& c) {
    if (c.met) return 1.0;
    if (c.quantity == Quantity::Length || c.quantity == Quantity::Angle)
        return c.limit > 0.0 ? c.value / c.limit : std::numeric_limits<double>::infinity();
    return 1.0 + std::max(1.0, std::abs(c.quantity == Quantity::Count ? c.value - c.limit : 1.0));
}

bool Verdict::met() const {
    return std::all_of(conditions.begin(), conditions.end(), [](const auto& c) { return c.met; });
}

const Condition* Verdict::worst() const {
    const auto worst =
        std::max_element(conditions.begin(), conditions.end(),
                         [](const auto& a, const auto& b) { return excess(a) < excess(b); });
    return worst == conditions.end() || worst->met ? nullptr : &*worst;
}

std::string Verdict::sentence(base::LengthUnit unit) const {
    const auto list = [](std::string text, const std::string& more) {
        return text + (text.empty() || more.empty() ? "" : ", ") + more;
    };
    if (met()) {
        const std::string limit = tolerance_rel ? " " + short_number(*tolerance_rel) : "";
        std::string text = shape;
        if (deviation_rel) text = list(text, short_number(*deviation_rel) + " of the diagonal");
        return "met" + limit + (text.empty() ? "" : ": " + text);
    }
    std::string text;
    for (const Condition& c : conditions) {
        if (c.met) continue;
        text = list(text, describe(c, tolerance_rel));
        if (!c.at) continue;
        const geom::Vec3 at = *c.at / base::millimetres_per(unit);
        text += fmt::format(" at ({:.4g}, {:.4g}, {:.4g})", at.x(), at.y(), at.z());
    }
    return fmt::format("MISSED: {}; try {}", text, worst()->remedy);
}

Verdict assess(const VerdictFigures& figures) {
    Verdict verdict{.conditions = Assessment(figures).conditions(),
                    .shape = describe_shape(figures)};
    if (!(figures.diagonal_mm > 0.0)) return verdict;
    if (figures.tolerance_mm) verdict.tolerance_rel = *figures.tolerance_mm / figures.diagonal_mm;
    for (const auto& way : {figures.output_to_input_mm, figures.input_to_output_mm})
        if (way)
            verdict.deviation_rel =
                std::max(verdict.deviation_rel.value_or(0.0), way->value / figures.diagonal_mm);
    return verdict;
}

bool better(const Verdict& a, const Verdict& b) {
    const auto rank = [](const Verdict& v) {
        bool invalid = false;
        double factors = 1.0;
        for (const Condition& c : v.conditions) {
            invalid = invalid || (!c.met && c.requirement == Requirement::Valid);
            factors *= excess(c);
        }
        return std::tuple(invalid, factors, v.deviation_rel.value_or(0.0));
    };
    return rank(a) < rank(b);
}

}  // namespace patchwright::measure
