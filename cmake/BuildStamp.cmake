# SPDX-License-Identifier: Apache-2.0

# cmake -DOUTPUT=... -DSOURCE=... -DCOMPILER=... -DFLAGS=... -DCUDA=... -P BuildStamp.cmake
# writes a header that says what is built, by what and how; leaves the file alone where it says so already.
set(commit unknown)
find_package(Git QUIET)
if(Git_FOUND)
  # A copy without a history of its own may lie in another repository.
  execute_process(COMMAND "${GIT_EXECUTABLE}" -C "${SOURCE}" rev-parse --show-prefix HEAD
    OUTPUT_VARIABLE answer OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed AND answer MATCHES "^\n?([0-9a-f]+)$")
    set(commit "${CMAKE_MATCH_1}")
    execute_process(COMMAND "${GIT_EXECUTABLE}" -C "${SOURCE}" status --porcelain -uno -- include backends examples
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
inline constexpr const char* commit = R"(@commit@)";
inline constexpr const char* compiler = R"(@COMPILER@)";
inline constexpr const char* flags = R"(@FLAGS@)";
inline constexpr const char* cuda = R"(@CUDA@)";
}  // namespace swiftgs::cli::stamp
]] text @ONLY)
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "${text}" @ONLY)
