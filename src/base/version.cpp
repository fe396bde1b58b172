#include <patchwright/base/version.h>

namespace patchwright::base {

std::string_view version() { return PATCHWRIGHT_VERSION; }

}  // namespace patchwright::base
