# Everyday work: optimised enough to run the tests, with assertions and debug information.
set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "")
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1" CACHE STRING "")
set(CMAKE_EXPORT_COMPILE_COMMANDS ON CACHE BOOL "")
set(PATCHWRIGHT_WARNINGS_AS_ERRORS ON CACHE BOOL "")
