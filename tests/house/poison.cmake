# tilth_poison(FOLDER HEADER...): headers that stop the compiler. First on the include path, they catch every include of
# the real ones, also an indirect one. kGlHeaders: what brings GL or a window system.
set(kGlHeaders GL/gl.h GL/glext.h GL/glcorearb.h GL/glx.h GL/osmesa.h GLES2/gl2.h GLES3/gl3.h EGL/egl.h EGL/eglext.h
    EGL/eglplatform.h KHR/khrplatform.h GLFW/glfw3.h glad/gl.h glad/egl.h glm/glm.hpp)

function(tilth_poison folder)
    foreach(header ${ARGN})
        file(WRITE "${folder}/${header}" "#error \"poisoned: ${header}\"\n")
    endforeach()
endfunction()

# tilth_run(WHAT COMMAND...): stops the test where the command fails; its output is in RUN_OUTPUT.
function(tilth_run what)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT status EQUAL 0)
        list(JOIN ARGN " " command)
        message(FATAL_ERROR "${what} failed (${status}): ${command}\n${output}")
    endif()
    set(RUN_OUTPUT "${output}" PARENT_SCOPE)
endfunction()
