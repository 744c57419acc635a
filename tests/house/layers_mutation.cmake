# layers_test.cmake accepts the sources as they are and refuses each kind of wrong include, naming the file.
set(failures 0)

# expect_layers(PASS|FAIL PATTERN): runs the layers test on the copy of the tree.
function(expect_layers verdict pattern)
    execute_process(COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${WORK_DIR} -P "${SOURCE_DIR}/tests/layers_test.cmake"
        RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
    string(REGEX REPLACE "[ \n]+" " " output "${output}")
    if(status EQUAL 0)
        set(got PASS)
    else()
        set(got FAIL)
    endif()
    if(NOT got STREQUAL verdict OR NOT output MATCHES "${pattern}")
        message(SEND_ERROR "expected ${verdict} with \"${pattern}\", got ${got}:\n${output}")
    endif()
endfunction()

# expect_refused(FILE TEXT PATTERN): a new file in the copy makes the test fail.
function(expect_refused file text pattern)
    file(WRITE "${WORK_DIR}/src/tilth/${file}" "${text}\n")
    expect_layers(FAIL "${pattern}")
    file(REMOVE "${WORK_DIR}/src/tilth/${file}")
endfunction()

file(REMOVE_RECURSE "${WORK_DIR}")
file(COPY "${SOURCE_DIR}/src" DESTINATION "${WORK_DIR}")
expect_layers(PASS "includes keep the order")
expect_refused(core/mutant.h "#include \"tilth/ground/ground.h\"" "core/mutant.h.*'core' must not include 'ground'")
expect_refused(ground/mutant.cpp "  #include \"tilth/gl/device.h\"" "ground/mutant.cpp.*'ground' must not include 'gl'")
expect_refused(world/mutant.h "#include \"tilth/terrain.h\"" "world/mutant.h.*only the facade")
expect_refused(source/mutant.h "#include <GL/gl.h>" "source/mutant.h.*without a GL header")
expect_refused(ground/mutant.h "#include <EGL/egl.h>" "ground/mutant.h.*without a GL header")
expect_refused(mutants/mutant.h "// a folder of no stage" "'mutants' is not in src/layers.txt")
expect_refused(render/mutant.h "#include \"tilth/mutants/other.h\"" "render/mutant.h.*must not include 'mutants'")
file(REMOVE_RECURSE "${WORK_DIR}/src/tilth/mutants")
expect_layers(PASS "includes keep the order")
