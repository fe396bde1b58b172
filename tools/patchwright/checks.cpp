#include "checks.h"

#include <patchwright/base/error.h>
#include <patchwright/base/units.h>

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>

namespace patchwright::cli {

namespace {

std::optional<double> finite_number(const std::string& text) {
    double value = 0.0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || rest != end || !std::isfinite(value)) return std::nullopt;
    return value;
}

/// What `parse` throws is what is wrong.
template <class Parse>
CLI::Validator parses(Parse parse) {
    return {[parse](std::string& text) -> std::string {
                try {
                    parse(text);
                } catch (const base::UsageError& error) {
                    return error.what();
                }
                return {};
            },
            ""};
}

}  // namespace

CLI::Validator number_in(double least, double most) {
    return {[=](std::string& text) -> std::string {
                const std::optional<double> value = finite_number(text);
                if (value && *value >= least && *value <= most) return {};
                return fmt::format("'{}' is no number from {} to {}", text, least, most);
            },
            fmt::format("{} to {}", least, most)};
}

CLI::Validator positive_up_to(double most) {
    return {[=](std::string& text) -> std::string {
                const std::optional<double> value = finite_number(text);
                if (value && *value > 0.0 && *value <= most) return {};
                return fmt::format("'{}' is no number above 0 and up to {}", text, most);
            },
            "above 0"};
}

CLI::Validator is_length() {
    return parses([](const std::string& text) { base::parse_length(text); });
}

CLI::Validator is_angle() {
    return parses([](const std::string& text) { base::parse_angle(text); });
}

CLI::Validator is_unit() {
    return parses([](const std::string& text) { base::parse_length_unit(text); });
}

CLI::Validator is_unit_or_input() {
    return parses([](const std::string& text) {
        if (text != "input") base::parse_length_unit(text);
    });
}

CLI::Validator is_not_empty() {
    return {[](std::string& text) { return std::string(text.empty() ? "is empty" : ""); }, ""};
}

}  // namespace patchwright::cli
