#include "call.h"

#include <new>
#include <system_error>

namespace patchwright::python {

namespace {

/// Short for a person, long beside what taking the interpreter's lock costs.
constexpr std::chrono::milliseconds between_calls{20};

void raise(const char* name, const std::string& text) {
    const py::object type = py::module_::import("patchwright.errors").attr(name);
    PyErr_SetString(type.ptr(), text.c_str());
}

/// The command line's messages, and classes with its exit codes.
void translate(std::exception_ptr error) {
    try {
        std::rethrow_exception(std::move(error));
    } catch (const base::InvalidArgument& wrong) {
        raise("UsageError", wrong.what());
    } catch (const base::InputError& unusable) {
        raise("InputError", unusable.what());
    } catch (const base::OutputError& unwritten) {
        raise("OutputError", unwritten.what());
    } catch (const base::TimeLimitReached&) {
        raise("TimeLimitError",
              "MISSED: the time limit was reached before there was a first result, and no result "
              "was written; try a longer time limit or a coarser tolerance");
    } catch (const base::Cancelled& cancelled) {
        raise("CancelledError", cancelled.what());
    } catch (const std::bad_alloc&) {
        raise("InternalError", "out of memory; no file was written or changed");
    } catch (const std::system_error& refused) {
        raise("InternalError", std::string("the system refuses: ") + refused.what());
    } catch (const base::Error& bug) {
        raise("InternalError", std::string("internal error, please report: ") + bug.what());
    }
}

}  // namespace

bool Call::tell(std::string_view stage, double fraction) {
    const auto now = std::chrono::steady_clock::now();
    if (stage == stage_ && now - told_ < between_calls) return true;
    stage_ = stage;
    told_ = now;
    const py::gil_scoped_acquire locked;
    try {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (progress_.is_none()) return true;
        const py::object answer = progress_(py::str(stage_), fraction);
        return answer.ptr() != Py_False;
    } catch (py::error_already_set& error) {
        raised_.emplace(std::move(error));
        return false;
    }
}

void register_errors() { py::register_exception_translator(translate); }

}  // namespace patchwright::python
