# SPDX-License-Identifier: Apache-2.0

# cmake -DOUTPUT=... -DSOURCE=... -DCOMPILER=... -DFLAGS=... -DCUDA=... -P BuildStamp.cmake
# writes a header that says what is built, by what and how; leaves the file alone where it says so already.
set(commit unknown)
find_package(Git QUIET)
if(Git_FOUND)
  execute_process(COMMAND "${GIT_EXECUTABLE}" -C "${SOURCE}" rev-parse HEAD
    OUTPUT_VARIABLE head OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed)
    set(commit "${head}")
    execute_process(COMMAND "${GIT_EXECUTABLE}" -C "${SOURCE}" status --porcelain -uno -- include backends
      OUTPUT_VARIABLE changed ERROR_QUIET)
    if(changed)
      string(APPEND commit "+")
    endif()
  endif()
endif()
string(CONFIGURE [[
// SPDX-License-Identifier: Apache-2.0
#pragma once

/// What is built, by what and how.
namespace swiftgs::cli::stamp {
inline constexpr const char* commit = "@commit@";
inline constexpr const char* compiler = "@COMPILER@";
inline constexpr const char* flags = "@FLAGS@";
inline constexpr const char* cuda = "@CUDA@";
}  // namespace swiftgs::cli::stamp
]] text @ONLY)
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "${text}" @ONLY)
