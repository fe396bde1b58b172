#include <patchwright/base/error.h>
#include <patchwright/base/progress.h>

namespace patchwright::base {

void report_progress(const Progress& progress, std::string_view stage, double fraction) {
    if (progress && !progress(stage, fraction)) throw Cancelled();
}

}  // namespace patchwright::base
