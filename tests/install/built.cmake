# SPDX-License-Identifier: Apache-2.0

# cmake -DBUILT=<build> -DEMBEDDED=<the same project in another build> -P built.cmake -- COMPILER ARGUMENTS...
#
# A launcher of compilers: copies the object that BUILT has of the same source and library, and compiles what it has
# none of. Of each library a file is compiled anyway, which tells whether its flags suffice.
cmake_minimum_required(VERSION 3.25)
set(compiled_anyway cuda_vulkan.cpp gl.cpp identity.cpp memory.cpp raster_per_pixel.cu scene.cpp unity_reference_cxx.cxx)

set(command)
foreach(i RANGE 0 ${CMAKE_ARGC})
  if(DEFINED begun)
    list(APPEND command "${CMAKE_ARGV${i}}")
  elseif(CMAKE_ARGV${i} STREQUAL "--")
    set(begun ON)
  endif()
endforeach()
list(FIND command -o at)
math(EXPR at "${at} + 1")
list(GET command ${at} object)
cmake_path(ABSOLUTE_PATH object)
cmake_path(GET object STEM LAST_ONLY source)
cmake_path(RELATIVE_PATH object BASE_DIRECTORY "${EMBEDDED}" OUTPUT_VARIABLE place)
if(place MATCHES "^backends/" AND EXISTS "${BUILT}/${place}" AND NOT source IN_LIST compiled_anyway)
  file(COPY_FILE "${BUILT}/${place}" "${object}")
else()
  execute_process(COMMAND ${command} COMMAND_ERROR_IS_FATAL ANY)
endif()
