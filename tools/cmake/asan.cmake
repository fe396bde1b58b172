# Address and undefined-behaviour sanitizers over the tests.
set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "")
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g" CACHE STRING "")
set(CMAKE_CXX_FLAGS "-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer"
    CACHE STRING "")
# The sanitizers make GCC 12 warn of uninitialised members inside std::function.
set(PATCHWRIGHT_WARNINGS_AS_ERRORS OFF CACHE BOOL "")
