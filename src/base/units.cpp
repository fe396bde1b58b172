#include <patchwright/base/error.h>
#include <patchwright/base/units.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace patchwright::base {

namespace {

struct UnitRow {
    LengthUnit unit;
    std::string_view name;
    double millimetres;
};

constexpr std::array<UnitRow, 5> unit_table{{{LengthUnit::Millimetre, "mm", 1.0},
                                             {LengthUnit::Centimetre, "cm", 10.0},
                                             {LengthUnit::Metre, "m", 1000.0},
                                             {LengthUnit::Inch, "in", 25.4},
                                             {LengthUnit::Foot, "ft", 304.8}}};

/// As people write them.
struct LongNames {
    LengthUnit unit;
    std::array<std::string_view, 2> names;
};

constexpr std::array<LongNames, 5> long_names{
    {{LengthUnit::Millimetre, {"millimetres", "millimeters"}},
     {LengthUnit::Centimetre, {"centimetres", "centimeters"}},
     {LengthUnit::Metre, {"metres", "meters"}},
     {LengthUnit::Inch, {"inch", "inches"}},
     {LengthUnit::Foot, {"foot", "feet"}}}};

struct PositiveNumber {
    double value;
    std::string_view unit;
};

/// @throw UsageError with what is wanted
PositiveNumber parse_positive(std::string_view text, std::string_view wanted) {
    double value = 0.0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || !std::isfinite(value) || value <= 0.0)
        throw UsageError(fmt::format("'{}' is no {}", text, wanted));
    std::string_view unit = text.substr(static_cast<std::size_t>(rest - text.data()));
    while (unit.starts_with(' ')) unit.remove_prefix(1);
    return {value, unit};
}

const UnitRow& row_of(LengthUnit unit) { return unit_table[static_cast<std::size_t>(unit)]; }

}  // namespace

double millimetres_per(LengthUnit unit) { return row_of(unit).millimetres; }

std::string_view short_name(LengthUnit unit) { return row_of(unit).name; }

std::optional<LengthUnit> likely_unit(double millimetres) {
    const auto factor = [&](const UnitRow& row) {
        return std::max(millimetres / row.millimetres, row.millimetres / millimetres);
    };
    const UnitRow& nearest = *std::min_element(
        unit_table.begin(), unit_table.end(),
        [&](const UnitRow& a, const UnitRow& b) { return factor(a) < factor(b); });
    if (factor(nearest) < 2.0) return nearest.unit;
    return std::nullopt;
}

LengthUnit parse_length_unit(std::string_view text) {
    for (const UnitRow& row : unit_table) {
        if (row.name == text) return row.unit;
    }
    for (const auto& [unit, names] : long_names) {
        if (std::find(names.begin(), names.end(), text) != names.end()) return unit;
    }
    throw UsageError(fmt::format("'{}' is no length unit; use mm, cm, m, in or ft", text));
}

double Length::in_millimetres(double diagonal_mm) const {
    return value * (unit ? millimetres_per(*unit) : diagonal_mm);
}

Length parse_length(std::string_view text) {
    const auto [value, unit] = parse_positive(
        text, "length; use a positive number with a unit, such as 0.05mm or 1e-4rel");
    Length length{.value = value};
    if (unit.empty())
        throw UsageError(fmt::format(
            "'{0}' has no unit; add a unit: {0}mm, {0}in, or 1e-4rel (of the diagonal)", text));
    if (unit != "rel") length.unit = parse_length_unit(unit);
    if (length.unit && !std::isfinite(length.in_millimetres(0.0)))
        throw UsageError(fmt::format("'{}' is too long to be measured in millimetres", text));
    return length;
}

double parse_angle(std::string_view text) {
    const auto [value, unit] =
        parse_positive(text, "angle; use a positive number with a unit, such as 0.5deg or 0.01rad");
    if (unit == "rad") return value;
    if (unit != "deg")
        throw UsageError(fmt::format("'{}' has no unit of angles; add deg or rad", text));
    return value * M_PI / 180.0;
}

}  // namespace patchwright::base
