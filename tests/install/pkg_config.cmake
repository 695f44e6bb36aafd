# SPDX-License-Identifier: Apache-2.0

# Builds SOURCE of STANDARD with DEFINITIONS in FOLDER by what PKG_CONFIG says of PACKAGES in LIBRARIES, and runs it.
# Fails unless it leaves all FILES.
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")
set(ENV{PKG_CONFIG_PATH} "${LIBRARIES}/pkgconfig:$ENV{PKG_CONFIG_PATH}")
execute_process(COMMAND "${PKG_CONFIG}" --cflags --libs ${PACKAGES}
  OUTPUT_VARIABLE options OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(options UNIX_COMMAND "${options}")
execute_process(COMMAND ${COMPILER} -std=${STANDARD} "${SOURCE}" ${DEFINITIONS} -o "${FOLDER}/program" ${options}
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${FOLDER}/program" WORKING_DIRECTORY "${FOLDER}" COMMAND_ERROR_IS_FATAL ANY)
foreach(file IN LISTS FILES)
  if(NOT EXISTS "${file}")
    message(FATAL_ERROR "expected ${file}")
  endif()
endforeach()
