# A host adds the tree with add_subdirectory and links tilth::ground. Programs, tests and install rules stay off, and the
# host's own settings stay as they were.
include("${CMAKE_CURRENT_LIST_DIR}/poison.cmake")
set(flags "")
if(SANITIZE)
    set(flags "-fsanitize=${SANITIZE}")
endif()
tilth_run("configuring the host" ${CMAKE_COMMAND} -S "${SOURCE_DIR}/tests/house/host" -B "${WORK_DIR}" -G Ninja
    "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" -DCMAKE_BUILD_TYPE=Debug
    "-DCMAKE_CXX_FLAGS=${flags}" "-DTILTH_FOLDER=${SOURCE_DIR}" "-DTILTH_GLAD_DIR=${GLAD_DIR}")
tilth_run("building the host's program" ${CMAKE_COMMAND} --build "${WORK_DIR}" --target stamped_ground)
tilth_run("running it" "${WORK_DIR}/stamped_ground")
message(STATUS "${RUN_OUTPUT}")
