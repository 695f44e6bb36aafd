# SPDX-License-Identifier: Apache-2.0

# cmake -DCOMPILER=... -DHEADER=... -DFOLDERS=<include folders> -DLINES=<most> -DFOLDER=<for files> -P check_size.cmake
#
# Preprocesses a source that includes HEADER alone. Fails where that is longer than LINES, or brings <fstream>, oneTBB or
# Eigen to whoever includes it.
string(MAKE_C_IDENTIFIER "${HEADER}" name)
set(source "${FOLDER}/${name}.cpp")
file(WRITE "${source}" "#include <${HEADER}>\n")
list(TRANSFORM FOLDERS PREPEND -I)
execute_process(COMMAND "${COMPILER}" -std=c++20 -E ${FOLDERS} "${source}" -o "${source}.i" COMMAND_ERROR_IS_FATAL ANY)
file(STRINGS "${source}.i" markers REGEX "^# [0-9]+ \"[^\"]*(/fstream|/tbb/|/Eigen/)[^\"]*\"")
if(markers)
  list(GET markers 0 first)
  message(FATAL_ERROR "${HEADER}: expected neither <fstream> nor oneTBB nor Eigen, found ${first}")
endif()
file(READ "${source}.i" text)
string(REGEX REPLACE "[^\n]" "" text "${text}")
string(LENGTH "${text}" lines)
message("${HEADER}: ${lines} lines")
if(lines GREATER LINES)
  message(FATAL_ERROR "${HEADER}: expected at most ${LINES} preprocessed lines, found ${lines}")
endif()
