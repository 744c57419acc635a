# How layers (one object target per folder of src/tilth) and the exported libraries are made.
include(GNUInstallDirs)

# A host that adds this project as a subdirectory, perhaps with a newer compiler, is not stopped by a new warning.
option(TILTH_WARNINGS_ARE_ERRORS "stop at the first warning" ${PROJECT_IS_TOP_LEVEL})

add_library(tilth_flags INTERFACE)
target_compile_features(tilth_flags INTERFACE cxx_std_20)
# -ffp-contract=off: the CPU executor's floats must not depend on whether the compiler may fuse a multiply and an add.
target_compile_options(tilth_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wcast-qual
    -Wno-missing-field-initializers $<$<BOOL:${TILTH_WARNINGS_ARE_ERRORS}>:-Werror>
    -ffp-contract=off -fno-math-errno -fno-trapping-math)
if(TILTH_SANITIZE)
    # vptr needs the type information that the library is built without.
    target_compile_options(tilth_flags INTERFACE -fsanitize=${TILTH_SANITIZE} -fno-sanitize=vptr -fno-omit-frame-pointer -fno-sanitize-recover=all)
    target_link_options(tilth_flags INTERFACE -fsanitize=${TILTH_SANITIZE})
endif()

# tilth_layer(NAME [USES LAYER...]): the object target tilth_layer_NAME from src/tilth/NAME, with its folders.
# "terrain" is the facade: the files that lie directly in src/tilth.
function(tilth_layer name)
    cmake_parse_arguments(ARG "" "" "USES" ${ARGN})
    if(name STREQUAL "terrain")
        set(files "${PROJECT_SOURCE_DIR}/src/tilth/*.cpp")
    else()
        set(files "${PROJECT_SOURCE_DIR}/src/tilth/${name}/*.cpp" "${PROJECT_SOURCE_DIR}/src/tilth/${name}/*/*.cpp")
    endif()
    file(GLOB sources CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}" ${files})
    list(TRANSFORM sources PREPEND "${PROJECT_SOURCE_DIR}/")
    if(NOT sources)  # a layer of headers alone
        set(sources "${PROJECT_BINARY_DIR}/empty.cpp")
        file(CONFIGURE OUTPUT "${sources}" CONTENT "")
    endif()
    add_library(tilth_layer_${name} OBJECT ${sources})
    target_include_directories(tilth_layer_${name} PUBLIC
        $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/shaders>)
    target_compile_options(tilth_layer_${name} PRIVATE -fno-exceptions -fno-rtti -fvisibility=hidden)
    target_link_libraries(tilth_layer_${name} PRIVATE $<BUILD_INTERFACE:tilth_flags>)
    set_target_properties(tilth_layer_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_EXTENSIONS OFF)
    foreach(used ${ARG_USES})
        target_include_directories(tilth_layer_${name} PUBLIC
            $<TARGET_PROPERTY:tilth_layer_${used},INTERFACE_INCLUDE_DIRECTORIES>)
    endforeach()
endfunction()

# tilth_library(NAME LAYERS LAYER... [USES TARGET...]): the static library tilth_NAME, exported as tilth::NAME.
function(tilth_library name)
    cmake_parse_arguments(ARG "" "" "LAYERS;USES" ${ARGN})
    add_library(tilth_${name} STATIC)
    add_library(tilth::${name} ALIAS tilth_${name})
    foreach(layer ${ARG_LAYERS})
        target_sources(tilth_${name} PRIVATE $<TARGET_OBJECTS:tilth_layer_${layer}>)
    endforeach()
    target_compile_features(tilth_${name} PUBLIC cxx_std_20)
    target_include_directories(tilth_${name} PUBLIC
        $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/shaders>
        $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/tilth/shaders>)
    target_link_libraries(tilth_${name} PUBLIC ${ARG_USES})
    set_target_properties(tilth_${name} PROPERTIES EXPORT_NAME ${name} LINKER_LANGUAGE CXX)
endfunction()

# tilth_program_flags(TARGET): warnings and sanitizers for programs and tests, which may use exceptions.
function(tilth_program_flags target)
    target_link_libraries(${target} PRIVATE tilth_flags)
    set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
endfunction()
