// Tests that need files which may be absent.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <iostream>

namespace patchwright::test {

/// False when one of the files is absent, which it says in the words that make CTest count the test
/// as skipped. To be asked before the first check: a test that fails must not be skipped.
inline bool all_there(const std::filesystem::path& folder,
                      std::initializer_list<const char*> names) {
    for (const char* name : names) {
        if (std::filesystem::exists(folder / name)) continue;
        std::cout << "SKIPPED: " << (folder / name).string() << " is absent\n";
        return false;
    }
    return true;
}

}  // namespace patchwright::test
