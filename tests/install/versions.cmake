# SPDX-License-Identifier: Apache-2.0

# cmake -DROOT=<sources> -DPREFIX=<installed> -DLIBRARIES=<its libraries> -P versions.cmake
#
# Fails unless what is installed states one version: the header, CMake, pkg-config, the command line and the latest
# entry of the changelog. Shared C libraries are named for their binary interface.
file(STRINGS "${PREFIX}/include/swiftgs/version.hpp" numbers REGEX "^#define SWIFTGS_VERSION_(MAJOR|MINOR|PATCH) [0-9]+$")
list(TRANSFORM numbers REPLACE "^.* " "")
list(JOIN numbers . version)
if(NOT version MATCHES "^[0-9]+[.][0-9]+[.][0-9]+$")
  message(FATAL_ERROR "${PREFIX}/include/swiftgs/version.hpp: expected three numbers, found '${version}'")
endif()

function(expect place said pattern)
  string(REGEX MATCH "${pattern}" line "${said}")
  if(NOT CMAKE_MATCH_1 STREQUAL version)
    message(SEND_ERROR "${place}: expected version ${version}, found '${line}'")
  endif()
endfunction()

set(config "${LIBRARIES}/cmake/swiftgs/swiftgsConfigVersion.cmake")
file(READ "${config}" said)
expect("${config}" "${said}" "PACKAGE_VERSION \"([0-9.]+)\"")
file(GLOB packages "${LIBRARIES}/pkgconfig/swiftgs*.pc")
list(LENGTH packages count)
if(count LESS 2)
  message(SEND_ERROR "${LIBRARIES}/pkgconfig: expected a file for each library, found '${packages}'")
endif()
foreach(package IN LISTS packages)
  file(READ "${package}" said)
  expect("${package}" "${said}" "\nVersion: ([0-9.]+)\n")
endforeach()
if(EXISTS "${PREFIX}/bin/swiftgs")
  execute_process(COMMAND "${PREFIX}/bin/swiftgs" --version OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
  expect("swiftgs --version" "${said}" "^swiftgs ([0-9.]+)\n$")
endif()
file(READ "${ROOT}/CHANGELOG.md" said)
expect("CHANGELOG.md" "${said}" "\n## .([0-9.]+). - [0-9-]+\n")

file(STRINGS "${PREFIX}/include/swiftgs/c/status.h" abi REGEX "^#define SWIFTGS_ABI_(MAJOR|MINOR) [0-9]+$")
list(TRANSFORM abi REPLACE "^.* " "")
list(GET abi 0 major)
list(JOIN abi . abi)
foreach(name IN ITEMS "${major}" "${abi}")
  file(GLOB found "${LIBRARIES}/libswiftgs_c.so.${name}*")
  if(EXISTS "${LIBRARIES}/libswiftgs_c.so" AND NOT found)
    message(SEND_ERROR "${LIBRARIES}: expected libswiftgs_c.so.${name}, for the binary interface ${abi}")
  endif()
endforeach()
