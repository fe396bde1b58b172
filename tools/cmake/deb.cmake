# The Debian package, build/deb/patchwright_*.deb, on the Debian that it is for:
#   cmake -S . -B build/deb -G Ninja -C tools/cmake/deb.cmake && cmake --build build/deb --target package
include(${CMAKE_CURRENT_LIST_DIR}/release.cmake)
set(CMAKE_INSTALL_PREFIX /usr CACHE PATH "")
set(CMAKE_SKIP_INSTALL_RPATH ON CACHE BOOL "")
set(PATCHWRIGHT_BUILD_TESTS OFF CACHE BOOL "")
set(PATCHWRIGHT_SHARED ON CACHE BOOL "")
set(PATCHWRIGHT_WITH_PYTHON ON CACHE BOOL "")
set(PATCHWRIGHT_PYTHON_INSTALL_DIR lib/python3/dist-packages CACHE STRING "")
set(PATCHWRIGHT_ZSH_INSTALL_DIR share/zsh/vendor-completions CACHE STRING "")
