// STL files of any bytes, and polygons of OBJ files: refused with an InputError, or read into
// triangles of which no more than two meet at a side.
#include <patchwright/base/error.h>
#include <patchwright/mesh/read_triangles.h>

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

using namespace patchwright;

namespace {

/// In memory, one a process; the reader goes by the extension.
std::filesystem::path file(const char* extension) {
    return "/dev/shm/patchwright_fuzz_" + std::to_string(::getpid()) + extension;
}

void read(const std::filesystem::path& path, const std::uint8_t* data, std::size_t size) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), std::streamsize(size));
    try {
        const mesh::TriangleFile result = mesh::read_triangles(path);
        std::map<std::pair<int, int>, int> uses;
        for (const auto& t : result.mesh.triangles) {
            for (std::size_t k = 0; k < 3; ++k) {
                const int a = t[k], b = t[(k + 1) % 3];
                if (a < 0 || a >= result.mesh.points.rows()) std::abort();
                if (++uses[{std::min(a, b), std::max(a, b)}] > 2) std::abort();
            }
        }
    } catch (const base::InputError&) {
        return;
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::filesystem::path stl = file(".stl"), obj = file(".obj");
    if (size == 0) return 0;
    // The first byte chooses the reader.
    read(data[0] % 4 == 0 ? obj : stl, data + 1, size - 1);
    return 0;
}
