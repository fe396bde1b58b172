# Round-trip deviation tests for projects that write, read or convert CAD files.
#
#   patchwright_add_round_trip_test(NAME name A file B file TOLERANCE length [SAMPLES number])
#
# A test that fails unless B, which came of A, is as good as A: no point of either is farther from the
# other than the tolerance ("0.05mm", or "1e-4rel" of A's diagonal), long sharp curves of A are sharp
# curves of B, and B is valid, and closed where A is. Its output says figure, place and tolerance.
# STEP, IGES, BREP, STL, OBJ; relative names are below CMAKE_CURRENT_BINARY_DIR. Where another test
# writes B: set_tests_properties(... FIXTURES_REQUIRED ...).
function(patchwright_add_round_trip_test)
    cmake_parse_arguments(PARSE_ARGV 0 ARG "" "NAME;A;B;TOLERANCE;SAMPLES" "")
    foreach(needed NAME A B TOLERANCE)
        if(NOT DEFINED ARG_${needed})
            message(FATAL_ERROR "patchwright_add_round_trip_test needs ${needed}")
        endif()
    endforeach()
    if(DEFINED ARG_UNPARSED_ARGUMENTS)
        message(FATAL_ERROR "patchwright_add_round_trip_test does not know ${ARG_UNPARSED_ARGUMENTS}")
    endif()
    if(NOT TARGET patchwright::patchwright)
        message(FATAL_ERROR "patchwright_add_round_trip_test: this patchwright was built without OpenCASCADE")
    endif()
    set(samples)
    if(DEFINED ARG_SAMPLES)
        set(samples --samples ${ARG_SAMPLES})
    endif()
    add_test(NAME ${ARG_NAME} COMMAND $<TARGET_FILE:patchwright::patchwright> compare ${ARG_A} ${ARG_B}
        --tolerance ${ARG_TOLERANCE} ${samples})
endfunction()
