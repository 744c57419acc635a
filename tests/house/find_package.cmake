# Installs into an empty folder; a stranger's project finds the package there, builds against it alone and runs.
include("${CMAKE_CURRENT_LIST_DIR}/poison.cmake")
file(REMOVE_RECURSE "${WORK_DIR}")
tilth_run("installing" ${CMAKE_COMMAND} --install "${BUILD_DIR}" --prefix "${WORK_DIR}/prefix")
if(EXISTS "${WORK_DIR}/prefix/include/tilth/gl/api.h")
    message(SEND_ERROR "gl/api.h, which includes the private GL loader, is installed")
endif()

# The installed headers alone: no GL, no window system, none of the libraries inside. "tests" must not matter either.
tilth_poison("${WORK_DIR}/poison" ${kGlHeaders} OpenImageIO/imageio.h OpenImageIO/filesystem.h xxhash.h toml++/toml.h)
set(includes "")
set(count 0)
foreach(folder tilth tilth/core tilth/world tilth/source tilth/ground tilth/io tilth/gl tilth/context tilth/pool
        tilth/deform tilth/derive tilth/render)
    file(GLOB headers RELATIVE "${WORK_DIR}/prefix/include" "${WORK_DIR}/prefix/include/${folder}/*.h")
    foreach(header ${headers})
        string(APPEND includes "#include \"${header}\"\n")
        math(EXPR count "${count} + 1")
    endforeach()
endforeach()
if(count LESS 30)
    message(FATAL_ERROR "only ${count} headers were installed")
endif()
file(WRITE "${WORK_DIR}/all_headers.h" "${includes}")

set(flags "")
if(SANITIZE)
    set(flags "-fsanitize=${SANITIZE}")
endif()
tilth_run("configuring the consumer" ${CMAKE_COMMAND} -S "${SOURCE_DIR}/tests/house/consumer" -B "${WORK_DIR}/build" -G Ninja
    "-DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix" "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}"
    "-DCMAKE_CXX_FLAGS=${flags}" "-DTILTH_COMPONENTS=${COMPONENTS}" "-DTILTH_VERSION=${VERSION}"
    "-DTILTH_HEADERS=${WORK_DIR}/all_headers.h" "-DTILTH_POISON=${WORK_DIR}/poison")
tilth_run("building the consumer" ${CMAKE_COMMAND} --build "${WORK_DIR}/build")
foreach(program stamped_ground every_library)
    tilth_run("${program}" ${CMAKE_COMMAND} -E env LIBGL_ALWAYS_SOFTWARE=1 "${WORK_DIR}/build/${program}")
    message(STATUS "${program}: ${RUN_OUTPUT}")
endforeach()

# Nothing that was installed remembers where it was built.
file(GLOB_RECURSE texts "${WORK_DIR}/prefix/*.cmake" "${WORK_DIR}/prefix/*.h" "${WORK_DIR}/prefix/*.glsl")
foreach(file ${texts})
    file(READ "${file}" content)
    foreach(folder "${SOURCE_DIR}" "${BUILD_DIR}")
        string(FIND "${content}" "${folder}/" place)
        if(NOT place EQUAL -1)
            message(SEND_ERROR "${file} names ${folder}")
        endif()
    endforeach()
endforeach()
