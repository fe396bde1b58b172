// OBJ files of any bytes, as control meshes: refused with an InputError, or read into a cage whose
// text gives the same cage again.
#include <patchwright/base/error.h>
#include <patchwright/mesh/obj.h>

#include <cstdint>
#include <cstdlib>
#include <sstream>

using namespace patchwright;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::istringstream stream(std::string(reinterpret_cast<const char*>(data), size));
    try {
        const mesh::BuildResult result = mesh::read_obj(stream, "fuzz.obj");
        const std::string text = mesh::obj_text(result.cage);
        std::istringstream again(text);
        if (mesh::obj_text(mesh::read_obj(again, "again.obj").cage) != text) std::abort();
    } catch (const base::InputError&) {
        return 0;
    }
    return 0;
}
