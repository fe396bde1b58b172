# What users run and what is measured.
set(CMAKE_BUILD_TYPE Release CACHE STRING "")
