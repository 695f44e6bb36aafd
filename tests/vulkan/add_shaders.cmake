# SPDX-License-Identifier: Apache-2.0

# cmake -DMODULE=<swiftgsShaders.cmake> -DFOLDER=... -P add_shaders.cmake
#
# Configures a project for each wrong call of swiftgs_add_shaders, which has to be refused with EXPECTED.
function(refuses calls expected)
  file(REMOVE_RECURSE "${FOLDER}")
  file(WRITE "${FOLDER}/own.glsl")
  file(WRITE "${FOLDER}/other/own.glsl")
  file(WRITE "${FOLDER}/other/CMakeLists.txt" "swiftgs_add_shaders(program BOUNDS own.glsl)")
  file(WRITE "${FOLDER}/CMakeLists.txt" "cmake_minimum_required(VERSION 3.25)
project(calls LANGUAGES NONE)
add_library(swiftgs::vulkan INTERFACE IMPORTED)
add_executable(program own.glsl)
include([[${MODULE}]])
${calls}")
  execute_process(COMMAND ${CMAKE_COMMAND} -S "${FOLDER}" -B "${FOLDER}/build" OUTPUT_QUIET ERROR_VARIABLE said)
  string(REGEX REPLACE "[ \n]+" " " said "${said}")
  string(FIND "${said}" "${expected}" at)
  if(at EQUAL -1)
    message(SEND_ERROR "${calls}: expected \"${expected}\", found \"${said}\"")
  endif()
endfunction()

refuses("swiftgs_add_shaders(program SORT own.glsl)"
  "swiftgs_add_shaders(program SORT own.glsl): expected BOUNDS or RASTERIZER, found SORT")
refuses("swiftgs_add_shaders(program BOUNDS own.glsl more.glsl)" "expected one file, found more.glsl too")
refuses("swiftgs_add_shaders(program BOUNDS none.glsl)" "expected a file of GLSL at ${FOLDER}/none.glsl, found none")
refuses("swiftgs_add_shaders(program BOUNDS other)" "expected a file of GLSL at ${FOLDER}/other, found none")
refuses("add_subdirectory(other)" "expected a call in the folder of the target, ${FOLDER}")
refuses("swiftgs_add_shaders(program BOUNDS own.glsl)\nswiftgs_add_shaders(program RASTERIZER other/own.glsl)"
  "expected a file of another name, program has own_shaders already")
