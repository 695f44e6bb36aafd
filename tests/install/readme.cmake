# SPDX-License-Identifier: Apache-2.0

# cmake -DROOT=<sources> -DFOLDER=<empty or none> -DCTEST=<ctest> -DGENERATOR=... -DOPTIONS=... -P readme.cmake
#
# The reader of README.md: writes the program of twelve lines and the lines of CMake to files as they are printed,
# builds the one with the other, runs it, and fails unless there is an image.
file(READ "${ROOT}/README.md" page)
function(write_block opening name)
  string(FIND "${page}" "${opening}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "README.md: expected a block that begins with:\n${opening}")
  endif()
  string(LENGTH "${opening}" length)
  math(EXPR at "${at} + ${length}")
  string(SUBSTRING "${page}" ${at} -1 block)
  string(FIND "${block}" "\n```\n" end)
  math(EXPR end "${end} + 1")
  string(SUBSTRING "${block}" 0 ${end} block)
  file(WRITE "${FOLDER}/${name}" "${block}")
endfunction()

file(REMOVE_RECURSE "${FOLDER}")
write_block("<!-- examples/00_readme.cpp -->\n```cpp\n" main.cpp)
write_block("\n```cmake\n" CMakeLists.txt)
execute_process(COMMAND "${CTEST}" --build-and-test "${FOLDER}" "${FOLDER}/build" --build-generator "${GENERATOR}"
  --build-options ${OPTIONS} --test-command app COMMAND_ERROR_IS_FATAL ANY)
if(NOT EXISTS "${FOLDER}/build/frame.png")
  message(FATAL_ERROR "expected the program to leave ${FOLDER}/build/frame.png")
endif()
