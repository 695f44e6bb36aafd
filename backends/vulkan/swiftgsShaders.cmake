# SPDX-License-Identifier: Apache-2.0

# swiftgs_compile_shader(TARGET HEADER ARRAY SHADER [argument...]): adds HEADER to TARGET, with SHADER's SPIR-V in ARRAY.
function(swiftgs_compile_shader target header array shader)
  add_custom_command(OUTPUT "${header}" DEPENDS "${shader}" DEPFILE "${header}.d" VERBATIM
    COMMAND "${Vulkan_GLSLANG_VALIDATOR_EXECUTABLE}" --quiet -Os -V --target-env vulkan1.2 ${ARGN} --vn ${array}
            --depfile "${header}.d" -o "${header}" "${shader}")
  target_sources(${target} PRIVATE "${header}")
endfunction()

# swiftgs_add_shaders(TARGET BOUNDS|RASTERIZER FILE)
#
# Compiles the GLSL of a policy into TARGET, which links swiftgs::vulkan. Of the file NAME.glsl the header
# <NAME_shaders.hpp> declares `NAME_shaders`, for `swiftgs::vulkan::shaders`; `_` replaces what no identifier has. Call it
# in the CMakeLists.txt that adds TARGET, once a NAME. Needs glslangValidator.
function(swiftgs_add_shaders target kind file)
  set(call "swiftgs_add_shaders(${target} ${kind} ${file})")
  if(kind STREQUAL "BOUNDS")
    set(type BoundsShaders)
    set(kernels compact footprints emit)
  elseif(kind STREQUAL "RASTERIZER")
    set(type RasterShaders)
    set(kernels raster raster_long)
  else()
    message(FATAL_ERROR "${call}: expected BOUNDS or RASTERIZER, found ${kind}")
  endif()
  if(ARGN)
    message(FATAL_ERROR "${call}: expected one file, found ${ARGN} too")
  endif()
  cmake_path(ABSOLUTE_PATH file)
  if(NOT EXISTS "${file}" OR IS_DIRECTORY "${file}")
    message(FATAL_ERROR "${call}: expected a file of GLSL at ${file}, found none")
  endif()
  get_target_property(place ${target} SOURCE_DIR)
  if(NOT place STREQUAL CMAKE_CURRENT_SOURCE_DIR)
    message(FATAL_ERROR "${call}: expected a call in the folder of the target, ${place}")
  endif()
  cmake_path(GET file STEM LAST_ONLY name)
  string(MAKE_C_IDENTIFIER "${name}" name)
  get_target_property(names ${target} SWIFTGS_SHADERS)
  if(name IN_LIST names)
    message(FATAL_ERROR "${call}: expected a file of another name, ${target} has ${name}_shaders already")
  endif()
  set_property(TARGET ${target} APPEND PROPERTY SWIFTGS_SHADERS ${name})
  find_program(Vulkan_GLSLANG_VALIDATOR_EXECUTABLE glslangValidator)
  if(NOT Vulkan_GLSLANG_VALIDATOR_EXECUTABLE)
    message(FATAL_ERROR "${call}: expected glslangValidator (package glslang-tools)")
  endif()

  # Shaders include `policy.glsl`, which is found here alone and includes FILE by its place, not by its name.
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/${target}_shaders")
  set(own "${folder}/${name}")
  file(MAKE_DIRECTORY "${own}")
  file(REAL_PATH "${own}" from)
  file(REAL_PATH "${file}" to)
  file(RELATIVE_PATH relative "${from}" "${to}")
  file(CONFIGURE OUTPUT "${own}/policy.glsl" CONTENT "#include \"@relative@\"\n" @ONLY)

  get_target_property(version swiftgs::vulkan VERSION)
  set(includes)
  set(members)
  foreach(kernel IN LISTS kernels)
    # The name of the entry point tells renderers which kernel of which version it is.
    swiftgs_compile_shader(${target} "${own}/${kernel}.hpp" ${name}_${kernel}
      "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/shaders/${kernel}.comp"
      -DOWN_${kind} "-I${from}" --source-entrypoint main -e ${kernel}-${version})
    string(APPEND includes "#include \"${name}/${kernel}.hpp\"\n")
    string(APPEND members "    {${name}_${kernel}, std::size(${name}_${kernel})},\n")
  endforeach()
  # A namespace of the target: two libraries of a program may have files of one name.
  string(MAKE_C_IDENTIFIER "shaders_of_${target}" namespace)
  file(CONFIGURE OUTPUT "${folder}/${name}_shaders.hpp" @ONLY CONTENT "#pragma once

#include <swiftgs/vulkan/shaders.hpp>

inline namespace ${namespace} {
extern const swiftgs::vulkan::${type} ${name}_shaders;
}
")
  file(CONFIGURE OUTPUT "${folder}/${name}_shaders.cpp" @ONLY CONTENT "#include \"${name}_shaders.hpp\"

#include <iterator>

namespace {
${includes}}  // namespace

const swiftgs::vulkan::${type} ${namespace}::${name}_shaders{
${members}};
")
  target_sources(${target} PRIVATE "${folder}/${name}_shaders.cpp")
  target_include_directories(${target} PRIVATE "${folder}")
endfunction()
