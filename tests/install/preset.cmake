# SPDX-License-Identifier: Apache-2.0

# cmake -DROOT=<sources> -DPRESET=<name> -DFOLDER=<build> -DNINJA=<ninja> -DOPTIONS=... -DLINES=... -DINSTALLED=...
#       -P preset.cmake
#
# Configures by PRESET and installs what building by it would make. Fails unless configuring prints LINES, and unless
# the programs and libraries that are installed are INSTALLED. Without INSTALLED it fails unless installing is refused with
# the preset that installs.
file(REMOVE_RECURSE "${FOLDER}")
execute_process(COMMAND ${CMAKE_COMMAND} --preset ${PRESET} -B "${FOLDER}" -DCMAKE_SKIP_RPATH=ON
                        -DCMAKE_INSTALL_LIBDIR=lib "-DCMAKE_INSTALL_PREFIX=${FOLDER}/prefix" ${OPTIONS}
  WORKING_DIRECTORY "${ROOT}" OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
foreach(line IN LISTS LINES)
  if(NOT said MATCHES "${line}")
    message(FATAL_ERROR "expected a line '${line}' when the preset is configured:\n${said}")
  endif()
endforeach()

if(NOT INSTALLED)
  execute_process(COMMAND ${CMAKE_COMMAND} --install "${FOLDER}" --prefix "${FOLDER}/prefix"
    RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
  string(REGEX REPLACE "[ \n]+" " " said "${said}")
  if(result EQUAL 0 OR NOT said MATCHES "cmake --preset cpu -DCMAKE_INSTALL_PREFIX=FOLDER" OR EXISTS "${FOLDER}/prefix")
    message(FATAL_ERROR "the preset ${PRESET}: expected a refusal to install that names the preset cpu, found: ${said}")
  endif()
  return()
endif()

file(READ "${ROOT}/CMakePresets.json" presets)
string(REGEX MATCH "\"configurePreset\": \"${PRESET}\", \"targets\": \\[([^]]*)\\]" targets "${presets}")
string(REGEX MATCHALL "[a-z_]+" targets "${CMAKE_MATCH_1}")
if(PRESET STREQUAL "cpu" AND NOT targets STREQUAL "install")
  message(FATAL_ERROR "expected the build preset `cpu` to install, found the targets '${targets}'")
endif()

# An empty file for each program and library that building links: to build would compile the sources once more.
execute_process(COMMAND "${NINJA}" -C "${FOLDER}" -t commands ${targets}
  OUTPUT_VARIABLE commands COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL " (-o|qc) [^ ]+" linked "${commands}")
string(REGEX MATCHALL "cmake_symlink_library [^&]+" links "${commands}")
foreach(file IN LISTS linked)
  string(REGEX REPLACE "^ (-o|qc) " "" file "${file}")
  if(NOT file MATCHES "[.]o$")
    file(WRITE "${FOLDER}/${file}" "")
  endif()
endforeach()
foreach(link IN LISTS links)
  separate_arguments(link UNIX_COMMAND "${link}")
  execute_process(COMMAND ${CMAKE_COMMAND} -E ${link} WORKING_DIRECTORY "${FOLDER}" COMMAND_ERROR_IS_FATAL ANY)
endforeach()

# What is installed is optimised and runs on every processor of its kind: kernels are chosen when they run.
string(REGEX MATCHALL "-O[^ ]+|-m(arch|cpu)=[^ ]+" flags "${commands}")
list(REMOVE_DUPLICATES flags)
if(NOT flags STREQUAL "-O3")
  message(FATAL_ERROR "the preset ${PRESET}: expected to compile with -O3 for every processor, found '${flags}'")
endif()
execute_process(COMMAND ${CMAKE_COMMAND} --install "${FOLDER}" OUTPUT_QUIET
  COMMAND_ERROR_IS_FATAL ANY)
file(GLOB_RECURSE found LIST_DIRECTORIES false RELATIVE "${FOLDER}/prefix"
  "${FOLDER}/prefix/bin/*" "${FOLDER}/prefix/*.a" "${FOLDER}/prefix/*.so" "${FOLDER}/prefix/*.py")
list(SORT found)
if(NOT found STREQUAL INSTALLED)
  message(FATAL_ERROR "the preset ${PRESET}: expected to install ${INSTALLED}, found ${found}")
endif()
