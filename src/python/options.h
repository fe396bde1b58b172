// The options of a call by name, as Python gives them; errors are those of the command line.
#pragma once

#include "arrays.h"

#include <patchwright/base/error.h>

#include <pybind11/pybind11.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace patchwright::python {

namespace py = pybind11;

/// What stays None is absent. Values are of the types that the module's Python code has checked.
class Options {
  public:
    explicit Options(const py::dict& values) : values_(values) {}

    [[nodiscard]] std::optional<std::string> text(const char* name) const;
    [[nodiscard]] bool flag(const char* name) const;
    /// @throw UsageError when it is none, or not from `least` to `most`
    [[nodiscard]] std::optional<double> number(const char* name, double least, double most) const;
    [[nodiscard]] std::optional<int> integer(const char* name, int least, int most) const;
    [[nodiscard]] std::vector<std::string> texts(const char* name) const;
    [[nodiscard]] std::optional<Doubles> doubles(const char* name) const;

    /// @throw UsageError when it is none of the words
    template <class Enum>
    Enum choice(const char* name, std::initializer_list<std::pair<const char*, Enum>> words) const {
        const std::string given = text(name).value_or(words.begin()->first);
        std::string all;
        for (const auto& [word, meaning] : words) {
            if (given == word) return meaning;
            all += (all.empty() ? "" : ", ") + std::string(word);
        }
        throw base::UsageError(std::string(name) + ": '" + given + "' is none of " + all);
    }

    /// Names and values for a report.
    [[nodiscard]] std::vector<std::pair<std::string, std::string>> listed(
        const std::string& command) const;

  private:
    [[nodiscard]] py::object value(const char* name) const;

    py::dict values_;
};

}  // namespace patchwright::python
