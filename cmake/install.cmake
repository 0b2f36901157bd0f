# cmake --install: the program, its gallery, and the libraries with their headers as the CMake package `espalier`
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS espalier RUNTIME)
install(DIRECTORY clients/gallery DESTINATION ${CMAKE_INSTALL_DATADIR}/espalier)
install(DIRECTORY tests/conformance/cases/ DESTINATION ${CMAKE_INSTALL_DATADIR}/espalier/conformance)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/espalier)
set(libraries core files language derivation turtle simulation environment protocol client remote bmi)
foreach(library ${libraries})
  set_target_properties(espalier_${library} PROPERTIES EXPORT_NAME ${library})
endforeach()
set_target_properties(espalier_options PROPERTIES EXPORT_NAME options)
list(TRANSFORM libraries PREPEND espalier_)
install(TARGETS espalier_options ${libraries} EXPORT espalier ARCHIVE)
install(EXPORT espalier NAMESPACE espalier:: FILE espalier-targets.cmake DESTINATION ${package})

# the headers, as they are included: #include "engine/simulation/simulation.h"
install(DIRECTORY engine environment protocol DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/espalier
        FILES_MATCHING PATTERN "*.h" PATTERN "*.def" PATTERN "plugin_example" EXCLUDE PATTERN "decoding" EXCLUDE PATTERN "musl" EXCLUDE)
install(DIRECTORY clients/cpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/espalier/clients
        FILES_MATCHING PATTERN "*.h" PATTERN "example" EXCLUDE)
install(FILES clients/bmi/bmi.hxx clients/bmi/bmi_plugin.h clients/bmi/bmi_raster.h clients/bmi/espalier_bmi.h
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/espalier/clients/bmi)

write_basic_package_version_file(espalier-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/espalier-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/espalier-config-version.cmake DESTINATION ${package})
