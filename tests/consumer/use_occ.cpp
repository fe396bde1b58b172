#include <patchwright/base/error.h>
#include <patchwright/occ/cad_model.h>

int main() {
    try {
        patchwright::occ::read_cad("missing.step");
    } catch (const patchwright::base::InputError&) {
        return 0;
    }
    return 1;
}
