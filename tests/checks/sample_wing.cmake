# Runs GENERATOR into WORK_DIR and compares what it wrote with the files in SAMPLE_DIR, byte by byte.
execute_process(COMMAND ${GENERATOR} ${WORK_DIR} COMMAND_ERROR_IS_FATAL ANY)
foreach(name wing.step wing.igs wing_cage.obj)
    execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files ${WORK_DIR}/${name} ${SAMPLE_DIR}/${name}
        RESULT_VARIABLE differs)
    if(differs)
        message(SEND_ERROR "samples/wing/${name} is not what make_sample_wing writes; "
            "run `make_sample_wing samples/wing` and look at what changed")
    endif()
endforeach()
