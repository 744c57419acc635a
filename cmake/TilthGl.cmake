# The private GL loader (target tilth_glad) and the shaders embedded into layer gl.
#
# tilth_glad is an interface target: an include folder and two renamed functions. The loader's code is compiled once,
# as part of layer gl (src/tilth/gl/glad_loader.cpp), so it ends up in libtilth_tilth.a and nowhere else. It is glad2's
# "mx" form: a struct of function pointers, no global gl* symbol; the renaming leaves no glad* symbol either, so a host
# may link its own glad.

set(TILTH_GLAD_EXTENSIONS
    GL_KHR_debug
    GL_ARB_buffer_storage
    GL_ARB_clip_control
    GL_ARB_copy_image
    GL_ARB_draw_buffers_blend
    GL_ARB_pipeline_statistics_query
    GL_ARB_tessellation_shader
    GL_ARB_texture_barrier
    GL_ARB_texture_filter_anisotropic
    GL_ARB_viewport_array
    GL_EXT_texture_filter_anisotropic)

function(tilth_generate_glad folder)
    list(JOIN TILTH_GLAD_EXTENSIONS "," extensions)
    # The stamp holds the list, so that a longer list generates anew.
    set(stamp "${folder}/extensions.txt")
    if(EXISTS "${folder}/src/gl.c" AND EXISTS "${stamp}")
        file(READ "${stamp}" made_with)
        if(made_with STREQUAL extensions)
            return()
        endif()
    endif()
    message(STATUS "tilth: generating the GL loader with glad2 (${TILTH_GLAD_PYTHON})")
    # --reproducible: from the specification that glad2 carries; without it, glad2 asks the network.
    execute_process(
        COMMAND "${TILTH_GLAD_PYTHON}" -m glad --quiet --reproducible --api gl:core=3.3 --extensions "${extensions}"
            --out-path "${folder}" c --mx
        RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT status EQUAL 0 OR NOT EXISTS "${folder}/src/gl.c")
        message(FATAL_ERROR "tilth: cannot generate the GL loader: \"${TILTH_GLAD_PYTHON} -m glad\" failed (${status}):\n"
            "${output}\nEither install glad2 for that Python (python3 -m venv VENV && VENV/bin/pip install glad2, then "
            "configure with -DTILTH_GLAD_PYTHON=VENV/bin/python), use ./run build, which does so, or name a folder that "
            "holds a ready loader with -DTILTH_GLAD_DIR=FOLDER (glad2, C, option mx, gl:core=3.3, ${extensions}).")
    endif()
    file(WRITE "${stamp}" "${extensions}")
endfunction()

if(TILTH_GLAD_DIR)
    set(tilth_glad_folder "${TILTH_GLAD_DIR}")
else()
    set(tilth_glad_folder "${PROJECT_BINARY_DIR}/glad")
    tilth_generate_glad("${tilth_glad_folder}")
endif()

# glad's own layout, or all files in one folder.
foreach(file "include/glad/gl.h" "glad/gl.h")
    if(EXISTS "${tilth_glad_folder}/${file}" AND NOT tilth_glad_header)
        set(tilth_glad_header "${tilth_glad_folder}/${file}")
    endif()
endforeach()
foreach(file "src/gl.c" "gl.c" "glad/gl.c")
    if(EXISTS "${tilth_glad_folder}/${file}" AND NOT tilth_glad_code)
        set(tilth_glad_code "${tilth_glad_folder}/${file}")
    endif()
endforeach()
if(NOT tilth_glad_header OR NOT tilth_glad_code)
    message(FATAL_ERROR "tilth: TILTH_GLAD_DIR=${tilth_glad_folder} has no include/glad/gl.h with src/gl.c (or glad/gl.h "
        "with gl.c); generate them with: glad --reproducible --api gl:core=3.3 --out-path FOLDER c --mx")
endif()
cmake_path(GET tilth_glad_header PARENT_PATH tilth_glad_include)
cmake_path(GET tilth_glad_include PARENT_PATH tilth_glad_include)
cmake_path(GET tilth_glad_code PARENT_PATH tilth_glad_code_folder)

add_library(tilth_glad INTERFACE)
target_include_directories(tilth_glad SYSTEM INTERFACE "${tilth_glad_include}" "${tilth_glad_code_folder}")
target_compile_definitions(tilth_glad INTERFACE
    gladLoadGLContext=tilth_gl_load_context gladLoadGLContextUserPtr=tilth_gl_load_context_user_pointer)

# Shaders, as text in one generated file.
file(GLOB_RECURSE tilth_shader_files CONFIGURE_DEPENDS
    "${PROJECT_SOURCE_DIR}/shaders/*.glsl" "${PROJECT_SOURCE_DIR}/shaders/*.vert" "${PROJECT_SOURCE_DIR}/shaders/*.frag"
    "${PROJECT_SOURCE_DIR}/shaders/*.geom" "${PROJECT_SOURCE_DIR}/shaders/*.tesc" "${PROJECT_SOURCE_DIR}/shaders/*.tese")
set(tilth_embedded_shaders "${PROJECT_BINARY_DIR}/generated/embedded_shaders.cpp")
# The list goes through a file: a changed list is a changed dependency, also when a file is removed.
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/generated/embedded_shaders.txt" CONTENT "${tilth_shader_files}" @ONLY)
add_custom_command(
    OUTPUT "${tilth_embedded_shaders}"
    COMMAND "${CMAKE_COMMAND}" "-DROOT=${PROJECT_SOURCE_DIR}/shaders"
        "-DLIST=${PROJECT_BINARY_DIR}/generated/embedded_shaders.txt" "-DOUTPUT=${tilth_embedded_shaders}"
        -P "${CMAKE_CURRENT_LIST_DIR}/EmbedShaders.cmake"
    DEPENDS ${tilth_shader_files} "${PROJECT_BINARY_DIR}/generated/embedded_shaders.txt"
        "${CMAKE_CURRENT_LIST_DIR}/EmbedShaders.cmake"
    COMMENT "Embedding shaders"
    VERBATIM)
# The layer's target is made after this file is read.
cmake_language(EVAL CODE
    "cmake_language(DEFER CALL target_sources tilth_layer_gl PRIVATE [[${tilth_embedded_shaders}]])")
