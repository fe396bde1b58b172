# What is installed besides programs and headers: the shared library, the CMake package, the pkg-config
# file, the add-ons; and the Debian package (tools/cmake/deb.cmake).
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/patchwright)

if(PATCHWRIGHT_SHARED)
    set(rooms core)
    if(PATCHWRIGHT_WITH_OCC)
        list(APPEND rooms occ convert)
    endif()
    # The archives' objects; the archives themselves only tell what else is linked.
    list(TRANSFORM rooms REPLACE "(.+)" "$<TARGET_OBJECTS:patchwright_\\1>" OUTPUT_VARIABLE objects)
    list(TRANSFORM rooms PREPEND patchwright_ OUTPUT_VARIABLE archives)
    set(exported_symbols ${CMAKE_CURRENT_LIST_DIR}/exported_symbols.map)
    add_library(patchwright_shared SHARED ${objects})
    # Versions that differ in the second number are not compatible, as in the CMake package.
    set_target_properties(patchwright_shared PROPERTIES OUTPUT_NAME patchwright EXPORT_NAME shared
        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
        LINKER_LANGUAGE CXX LINK_DEPENDS ${exported_symbols} LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
    target_link_libraries(patchwright_shared PRIVATE ${archives} INTERFACE Eigen3::Eigen)
    target_link_options(patchwright_shared PRIVATE LINKER:--version-script=${exported_symbols} LINKER:--no-undefined
        LINKER:--as-needed)
    target_compile_features(patchwright_shared INTERFACE cxx_std_20)
    target_compile_definitions(patchwright_shared INTERFACE ${patchwright_eigen_definitions})
    target_include_directories(patchwright_shared INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
        $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
    install(TARGETS patchwright_shared EXPORT patchwrightSharedTargets)
    # The names of the archives, so that projects need not know which of both they get.
    foreach(room IN LISTS rooms)
        add_library(patchwright_shared_${room} INTERFACE)
        set_target_properties(patchwright_shared_${room} PROPERTIES EXPORT_NAME ${room})
        target_link_libraries(patchwright_shared_${room} INTERFACE patchwright_shared)
        install(TARGETS patchwright_shared_${room} EXPORT patchwrightSharedTargets)
    endforeach()
    install(EXPORT patchwrightSharedTargets NAMESPACE patchwright:: DESTINATION ${package_folder})

    file(RELATIVE_PATH prefix_from_pkgconfig /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
    list(TRANSFORM patchwright_eigen_definitions PREPEND -D OUTPUT_VARIABLE pkgconfig_definitions)
    list(JOIN pkgconfig_definitions " " pkgconfig_definitions)
    configure_file(tools/cmake/patchwright.pc.in ${CMAKE_CURRENT_BINARY_DIR}/patchwright.pc @ONLY)
    install(FILES ${CMAKE_CURRENT_BINARY_DIR}/patchwright.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endif()

configure_package_config_file(tools/cmake/patchwrightConfig.cmake.in
    ${CMAKE_CURRENT_BINARY_DIR}/patchwrightConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/patchwrightConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/patchwrightConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/patchwrightConfigVersion.cmake
              tools/cmake/patchwrightRoundTrip.cmake
        DESTINATION ${package_folder})
install(EXPORT patchwrightTargets NAMESPACE patchwright:: DESTINATION ${package_folder} COMPONENT archives)
if(PATCHWRIGHT_WITH_OCC)
    install(EXPORT patchwrightProgram NAMESPACE patchwright:: DESTINATION ${package_folder})
endif()

# Where FreeCAD and Blender look when the prefix is /usr; elsewhere the folders are to be copied.
if(PATCHWRIGHT_WITH_OCC)
    install(DIRECTORY tools/freecad/ DESTINATION ${CMAKE_INSTALL_DATADIR}/freecad/Mod/Patchwright
        PATTERN __pycache__ EXCLUDE)
    install(DIRECTORY tools/blender/patchwright_cage DESTINATION ${CMAKE_INSTALL_DATADIR}/blender/scripts/addons
        PATTERN __pycache__ EXCLUDE)
endif()
install(FILES src/docs/changelog.rst DESTINATION ${CMAKE_INSTALL_DOCDIR})

if(PROJECT_IS_TOP_LEVEL AND PATCHWRIGHT_SHARED)
    set(CPACK_GENERATOR DEB)
    # All but the archives, which would need the development packages of every library.
    set(CPACK_DEB_COMPONENT_INSTALL ON)
    set(CPACK_COMPONENTS_ALL Unspecified)
    set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
    set(CPACK_PACKAGING_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
    set(CPACK_STRIP_FILES ON)
    set(CPACK_PACKAGE_CONTACT "The maintainers of patchwright <maintainers@patchwright.invalid>")
    set(CPACK_PACKAGE_DESCRIPTION
"Program, C++ library with headers, Python module, FreeCAD workbench and
Blender add-on that turn CAD files and triangles into a few untrimmed bicubic
B-spline patches, measured against the input both ways, and into structured
grids.")
    set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
    set(CPACK_DEBIAN_PACKAGE_SECTION science)
    set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
    set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
    set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
    set(CPACK_DEBIAN_PACKAGE_DEPENDS "libeigen3-dev (>= 3.4)")
    if(patchwright_python_depends)
        string(APPEND CPACK_DEBIAN_PACKAGE_DEPENDS ", ${patchwright_python_depends}")
    endif()
    set(CPACK_DEBIAN_PACKAGE_SUGGESTS "blender (>= 3.4), cmake (>= 3.25), freecad (>= 0.20), g++, pkg-config")
    set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA postinst prerm triggers)
    list(TRANSFORM CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA PREPEND ${CMAKE_CURRENT_LIST_DIR}/deb/)
    set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
    include(CPack)
endif()
