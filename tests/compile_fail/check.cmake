# SPDX-License-Identifier: Apache-2.0

# Compiles CASE with COMPILER and ARGUMENTS. OUTCOME is `refused` or `accepted`.
file(STRINGS "${CASE}" lines REGEX "^// expected: ")
list(LENGTH lines count)
if(NOT count EQUAL 1)
  message(FATAL_ERROR "${CASE}: expected one line '// expected: REGEX', found ${count}")
endif()
string(REGEX REPLACE "^// expected: " "" expected "${lines}")

set(definition)
if(OUTCOME STREQUAL accepted)
  set(definition -DSWIFTGS_EXPECT_COMPILE)
endif()
execute_process(
  COMMAND "${COMPILER}" "${ARGUMENTS}" ${definition} "${CASE}"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)

if(OUTCOME STREQUAL accepted)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${CASE}: expected to compile with SWIFTGS_EXPECT_COMPILE:\n${output}")
  endif()
elseif(result EQUAL 0)
  message(FATAL_ERROR "${CASE}: expected not to compile")
elseif(NOT output MATCHES "${expected}")
  message(FATAL_ERROR "${CASE}: expected a message that matches '${expected}':\n${output}")
endif()
