# What users run and what is measured; built at once, not for editing.
set(CMAKE_BUILD_TYPE Release CACHE STRING "")
# As fast as -O3, which takes a third longer to compile.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG" CACHE STRING "")
set(CMAKE_UNITY_BUILD ON CACHE BOOL "")
set(PATCHWRIGHT_PRECOMPILED_HEADERS ON CACHE BOOL "")
