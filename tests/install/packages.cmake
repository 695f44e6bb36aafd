# SPDX-License-Identifier: Apache-2.0

# cmake -DROOT=<sources> -DFOLDER=<build> -DNINJA=<ninja> -DOPTIONS=... -DPACKAGES=... -P packages.cmake
#
# Configures by the preset `distribution`. Fails unless cpack would make PACKAGES, and unless all that is installed is in
# one of them; the licence alone is in each anyway.
file(REMOVE_RECURSE "${FOLDER}")
execute_process(COMMAND ${CMAKE_COMMAND} --preset distribution -B "${FOLDER}" "-DCMAKE_MAKE_PROGRAM=${NINJA}"
                        -DSWIFTGS_BUILD_CUDA=OFF ${OPTIONS}
  WORKING_DIRECTORY "${ROOT}" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
include("${FOLDER}/CPackConfig.cmake")
set(packages)
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  list(APPEND packages ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
endforeach()
list(SORT packages)
if(NOT packages STREQUAL PACKAGES)
  message(FATAL_ERROR "expected the packages ${PACKAGES}, found ${packages}")
endif()
file(GLOB_RECURSE scripts "${FOLDER}/cmake_install.cmake")
set(installed)
foreach(script IN LISTS scripts)
  file(STRINGS "${script}" lines REGEX "CMAKE_INSTALL_COMPONENT STREQUAL")
  list(TRANSFORM lines REPLACE "^.*STREQUAL \"([A-Za-z]+)\".*$" "\\1")
  list(APPEND installed ${lines})
endforeach()
list(REMOVE_DUPLICATES installed)
list(REMOVE_ITEM installed ${CPACK_COMPONENTS_ALL} licence)
if(installed)
  message(FATAL_ERROR "expected all that is installed in one of ${CPACK_COMPONENTS_ALL}, found ${installed}")
endif()
