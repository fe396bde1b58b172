#include <patchwright/mesh/obj.h>

#include <sstream>

int main() {
    std::istringstream square("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    const auto result = patchwright::mesh::read_obj(square, "square");
    return result.cage.topology->face_count() == 1 ? 0 : 1;
}
