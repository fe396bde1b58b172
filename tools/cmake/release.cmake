# What users run and what is measured.
set(CMAKE_BUILD_TYPE Release CACHE STRING "")
set(PATCHWRIGHT_WARNINGS_AS_ERRORS ON CACHE BOOL "")
