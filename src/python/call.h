// What every function of the module does around a call of the library.
#pragma once

#include <patchwright/base/about_input.h>
#include <patchwright/base/error.h>
#include <patchwright/base/progress.h>

#include <pybind11/pybind11.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace patchwright::python {

namespace py = pybind11;

/// One call from Python that may take long. Other threads run meanwhile; signals, as of Ctrl-C, and
/// the caller's callback are looked after at every progress of the library.
class Call {
  public:
    /// @param progress  None, or called with stage and fraction; False from it cancels
    explicit Call(py::object progress) : progress_(std::move(progress)) {}

    [[nodiscard]] base::Progress progress() {
        return [this](std::string_view stage, double fraction) { return tell(stage, fraction); };
    }

    /// Calls `body` without the interpreter's lock.
    /// @param input  errors of input that name no file are said to be of this one
    /// @throw what the callback or a signal's handler has raised, in place of Cancelled
    template <class Body>
    auto run(const std::string& input, Body&& body) {
        try {
            const py::gil_scoped_release released;
            return base::about_input(input, std::forward<Body>(body));
        } catch (const base::Cancelled&) {
            if (raised_) throw py::error_already_set(std::move(*raised_));
            throw;
        }
    }

  private:
    /// @return whether to go on
    bool tell(std::string_view stage, double fraction);

    py::object progress_;
    std::optional<py::error_already_set> raised_;
    std::string stage_;
    std::chrono::steady_clock::time_point told_;
};

/// Errors of the library become the classes of patchwright.errors.
void register_errors();

}  // namespace patchwright::python
