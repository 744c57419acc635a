# install rules and the package that find_package(tilth) reads.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(exported tilth_ground)
if(TILTH_BUILD_GL)
    list(APPEND exported tilth_tilth)
endif()
if(TILTH_BUILD_CONTEXT)
    list(APPEND exported tilth_context)
endif()
if(TILTH_BUILD_IO)
    list(APPEND exported tilth_io)
endif()
install(TARGETS ${exported} EXPORT tilthTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY "${PROJECT_SOURCE_DIR}/src/tilth" DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
    FILES_MATCHING PATTERN "*.h" PATTERN "gl/api.h" EXCLUDE)
# The arithmetic that C++ and GLSL share is included by headers as "shared/...".
install(DIRECTORY "${PROJECT_SOURCE_DIR}/shaders/shared" DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tilth/shaders)
install(FILES "${CMAKE_CURRENT_LIST_DIR}/FindOpenImageIO.cmake" DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tilth)
install(EXPORT tilthTargets NAMESPACE tilth:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tilth)
configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/tilthConfig.cmake.in" "${PROJECT_BINARY_DIR}/tilthConfig.cmake"
    INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tilth)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/tilthConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/tilthConfig.cmake" "${PROJECT_BINARY_DIR}/tilthConfigVersion.cmake"
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tilth)
