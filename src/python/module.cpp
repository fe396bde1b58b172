// patchwright._core: thin bindings. What users call, with checked arguments, is in
// patchwright/*.py.
#include "cage.h"
#include "call.h"
#include "grids.h"
#include "model.h"
#include "modes.h"
#include "runs.h"
#include "transfer.h"

#include <patchwright/base/parallel.h>
#include <patchwright/base/version.h>

#include <pybind11/pybind11.h>

PYBIND11_MODULE(_core, module) {
    using namespace patchwright;
    python::register_errors();
    python::bind_cage(module);
    python::bind_model(module);
    python::bind_runs(module);
    python::bind_grids(module);
    python::bind_transfer(module);
    python::bind_modes(module);
    module.def("version", [] { return std::string(base::version()); });
    module.def("thread_count", &base::thread_count);
    module.def("set_thread_count", [](int threads) {
        constexpr int most = 1024;  // each takes a stack
        if (threads < 0 || threads > most)
            throw base::UsageError("threads: " + std::to_string(threads) +
                                   " is no number from 0 to " + std::to_string(most));
        base::set_thread_count(threads);
    });
}
