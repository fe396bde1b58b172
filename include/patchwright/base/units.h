// Lengths and angles with units. The library computes in millimetres and radians; files and users
// speak other units.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#pragma GCC visibility push(default)
namespace patchwright::base {

enum class LengthUnit { Millimetre, Centimetre, Metre, Inch, Foot };

/// Millimetres in one `unit`.
double millimetres_per(LengthUnit unit);

/// Short name as used on the command line and in reports: "mm", "cm", "m", "in", "ft".
std::string_view short_name(LengthUnit unit);

/// The unit that is nearest to so many millimetres, by their ratio; empty when it is off by a
/// factor of 2 or more.
std::optional<LengthUnit> likely_unit(double millimetres);

/// @throw UsageError when `text` is none of mm, cm, m, in, ft
LengthUnit parse_length_unit(std::string_view text);

/// A length given absolutely or as a fraction of the model's bounding box diagonal.
struct Length {
    double value = 1e-4;
    std::optional<LengthUnit> unit;  ///< empty: `value` is relative to the diagonal

    /// The length in millimetres for a model whose diagonal is `diagonal_mm`.
    [[nodiscard]] double in_millimetres(double diagonal_mm) const;
};

/// Reads "0.05mm", "0.002in", "1e-4rel".
/// @throw UsageError when the number is missing, not positive, or the unit is unknown
Length parse_length(std::string_view text);

/// Reads "0.5deg", "0.01rad".
/// @return radians
/// @throw UsageError when the number is missing or not positive, or the unit is neither
double parse_angle(std::string_view text);

}  // namespace patchwright::base
#pragma GCC visibility pop
