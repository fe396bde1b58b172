// Cages of the folder samples.
#pragma once

#include <patchwright/mesh/obj.h>

#include <filesystem>
#include <string>

namespace patchwright::test {

inline mesh::Cage sample_cage(const std::string& name) {
    return mesh::read_obj(std::filesystem::path(PATCHWRIGHT_SAMPLES_DIR) / name).cage;
}

}  // namespace patchwright::test
