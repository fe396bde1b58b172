# Writes OUTPUT, the source of src/report/page_assets.h, from the files in SOURCE. NPM may be NOTFOUND: the page then has no
# script. WORK is a folder for npm.
cmake_minimum_required(VERSION 3.25)

set(script "")
if(NPM)
    file(REMOVE_RECURSE ${WORK})
    file(COPY ${SOURCE}/ DESTINATION ${WORK})
    execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --fetch-retries=0
        --fetch-timeout=30000 WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE error)
    if(result EQUAL 0)
        # Licences stay in the bundle, as its parts are given away with every page.
        execute_process(COMMAND ${WORK}/node_modules/.bin/esbuild page.js --bundle --minify --format=iife --target=es2020
            --legal-comments=inline --loader:.css=text --outfile=bundle.js --log-level=warning
            WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result ERROR_VARIABLE error)
    endif()
    if(result EQUAL 0)
        file(READ ${WORK}/bundle.js script)
    else()
        string(REGEX MATCH "(npm (error|ERR!)|ERROR)[^\n]*" error "${error}")
        message(WARNING "Reports will have no 3-D view, as it could not be bundled. To try again, remove ${OUTPUT}. ${error}")
    endif()
endif()
file(READ ${SOURCE}/page.css style)
file(WRITE ${OUTPUT} "#include \"report/page_assets.h\"

namespace patchwright::report {

std::string_view page_style() { return R\"PAGE(${style})PAGE\"; }

std::string_view page_script() { return R\"PAGE(${script})PAGE\"; }

}  // namespace patchwright::report
")
