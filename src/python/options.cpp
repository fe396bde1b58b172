#include "options.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>

namespace patchwright::python {

py::object Options::value(const char* name) const {
    return values_.contains(name) ? py::object(values_[name]) : py::none();
}

std::optional<std::string> Options::text(const char* name) const {
    const py::object given = value(name);
    if (given.is_none()) return std::nullopt;
    return py::str(given).cast<std::string>();
}

bool Options::flag(const char* name) const {
    const py::object given = value(name);
    return !given.is_none() && given.cast<bool>();
}

std::optional<double> Options::number(const char* name, double least, double most) const {
    const py::object given = value(name);
    if (given.is_none()) return std::nullopt;
    try {
        const auto number = given.cast<double>();
        if (number >= least && number <= most) return number;
    } catch (const py::cast_error&) {
        // Told below.
    }
    throw base::UsageError(fmt::format("{}: '{}' is no number from {} to {}", name,
                                       py::str(given).cast<std::string>(), least, most));
}

std::optional<int> Options::integer(const char* name, int least, int most) const {
    const std::optional<double> given = number(name, least, most);
    if (!given) return std::nullopt;
    if (*given == double(int(*given))) return int(*given);
    throw base::UsageError(fmt::format("{}: {} is no whole number", name, *given));
}

std::vector<std::string> Options::texts(const char* name) const {
    const py::object given = value(name);
    if (given.is_none()) return {};
    return given.cast<std::vector<std::string>>();
}

std::optional<Doubles> Options::doubles(const char* name) const {
    const py::object given = value(name);
    if (given.is_none()) return std::nullopt;
    return given.cast<Doubles>();
}

std::vector<std::pair<std::string, std::string>> Options::listed(const std::string& command) const {
    std::vector<std::pair<std::string, std::string>> all{{"command", command}};
    for (const auto& [key, given] : values_) {
        if (given.is_none()) continue;
        std::string name = py::str(key).cast<std::string>();
        std::replace(name.begin(), name.end(), '_', '-');
        const std::string shown = py::str(given).cast<std::string>();
        const bool is_flag = py::isinstance<py::bool_>(given),
                   is_array = py::isinstance<py::array>(given);
        all.emplace_back(name, is_flag    ? (given.cast<bool>() ? "true" : "false")
                               : is_array ? fmt::format("{} points", py::len(given))
                                          : shown);
    }
    return all;
}

}  // namespace patchwright::python
