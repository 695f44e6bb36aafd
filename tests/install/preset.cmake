# SPDX-License-Identifier: Apache-2.0

# cmake -DROOT=<sources> -DFOLDER=<build> -DNINJA=<ninja> -DOPTIONS=... -P preset.cmake
#
# Configures by the preset `cpu`. Fails unless configuring says what is built, and unless building by it builds and
# installs the libraries of the CPU and nothing else.
file(REMOVE_RECURSE "${FOLDER}")
execute_process(COMMAND ${CMAKE_COMMAND} --preset cpu -B "${FOLDER}" ${OPTIONS}
  WORKING_DIRECTORY "${ROOT}" OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
foreach(line IN ITEMS "backends: serial, cpu\n" "EXR:      (yes|no, OpenEXR)" "report:   no, " "tests:    no\n")
  if(NOT said MATCHES "${line}")
    message(FATAL_ERROR "expected a line '${line}' when the preset is configured:\n${said}")
  endif()
endforeach()

file(READ "${ROOT}/CMakePresets.json" presets)
string(REGEX MATCH "\"configurePreset\": \"cpu\", \"targets\": \\[\"install\"\\]" installs "${presets}")
if(NOT installs)
  message(FATAL_ERROR "expected the build preset `cpu` to install")
endif()
# What building would run: to run it would compile the libraries once more.
execute_process(COMMAND "${NINJA}" -C "${FOLDER}" -t commands install OUTPUT_VARIABLE commands COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "${FOLDER}" "" commands "${commands}")
string(REGEX MATCHALL "libswiftgs[_a-z]*[.](a|so)|cmake_install" made "${commands}")
list(REMOVE_DUPLICATES made)
list(SORT made)
if(NOT made STREQUAL "cmake_install;libswiftgs.a;libswiftgs_c.so;libswiftgs_cpu.a;libswiftgs_io.a" OR commands MATCHES "${ROOT}/(tests|examples)/")
  message(FATAL_ERROR "expected to build and install libswiftgs, libswiftgs_c, libswiftgs_cpu and libswiftgs_io alone: ${made}")
endif()
