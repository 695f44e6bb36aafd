# SPDX-License-Identifier: Apache-2.0

# Linked privately by every target that is compiled here; never by a user's.
# Sign conversions are left out: indices are int or size_t by meaning, and the casts would hide the arithmetic.
set(swiftgs_warnings -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion)
list(JOIN swiftgs_warnings "," host_warnings)
# What nvcc hands to the host's compiler is not pedantic.
list(APPEND swiftgs_warnings -Wpedantic $<$<BOOL:${SWIFTGS_WARNINGS_AS_ERRORS}>:-Werror>)
# Under sanitizers GCC 12 takes operands that its own intrinsics of AVX-512 leave undefined for mistakes.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  list(APPEND swiftgs_warnings -Wno-maybe-uninitialized)
endif()

add_library(swiftgs_warnings INTERFACE)
target_compile_options(swiftgs_warnings INTERFACE
  "$<$<COMPILE_LANGUAGE:C>:${swiftgs_warnings}>"
  "$<$<COMPILE_LANGUAGE:CXX>:${swiftgs_warnings}>"
  "$<$<COMPILE_LANGUAGE:CUDA>:-Xcompiler=${host_warnings}>"
  "$<$<AND:$<COMPILE_LANGUAGE:CUDA>,$<BOOL:${SWIFTGS_WARNINGS_AS_ERRORS}>>:SHELL:-Werror all-warnings>")
