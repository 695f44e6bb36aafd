# SPDX-License-Identifier: Apache-2.0

# Compiles SOURCE, which includes the files CASES, with COMPILER and ARGUMENTS. OUTCOME is `refused`, where the compiler
# must name each case and say what it expects, or `accepted`.
set(options)
if(OUTCOME STREQUAL accepted)
  set(options -DSWIFTGS_EXPECT_COMPILE)
elseif(COMPILER_ID MATCHES Clang)
  set(options -ferror-limit=0)
endif()
execute_process(
  COMMAND "${COMPILER}" "${ARGUMENTS}" ${options} "${SOURCE}"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)

if(OUTCOME STREQUAL accepted)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${SOURCE}: expected to compile with SWIFTGS_EXPECT_COMPILE:\n${output}")
  endif()
  return()
endif()
if(result EQUAL 0)
  message(FATAL_ERROR "${SOURCE}: expected not to compile")
endif()
foreach(file IN LISTS CASES)
  file(STRINGS "${file}" lines REGEX "^// expected [a-z_]+: ")
  if(NOT lines)
    message(FATAL_ERROR "${file}: expected a line '// expected CASE: REGEX', found none")
  endif()
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^// expected ([a-z_]+): .*$" "\\1" case "${line}")
    string(REGEX REPLACE "^// expected [a-z_]+: " "" expected "${line}")
    if(NOT output MATCHES "${case}(::|[.]cpp:)")
      message(FATAL_ERROR "${case}: expected not to compile:\n${output}")
    elseif(NOT output MATCHES "${expected}")
      message(FATAL_ERROR "${case}: expected a message that matches '${expected}':\n${output}")
    endif()
  endforeach()
endforeach()
